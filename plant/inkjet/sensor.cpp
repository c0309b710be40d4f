#include "plant/inkjet/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/grid/random.h"

namespace firn::plant {
namespace {

// Standard normal from 32 random bits: inverse of the distribution function, tabulated at 4096 intervals and
// interpolated. Standard deviation right to 1e-3, range +-4.4.
class NormalTable {
 public:
  NormalTable() {
    double z = -4.4;
    for (int n = 0; n <= kIntervals; ++n) {
      const double p = std::clamp(double(n) / kIntervals, 5.4e-6, 1.0 - 5.4e-6);
      for (int step = 0; step < 20; ++step) {  // Newton on the distribution function, from the last point
        const double error = 0.5 * std::erfc(-z / std::sqrt(2.0)) - p;
        z -= std::clamp(error * std::sqrt(2.0 * 3.14159265358979324) * std::exp(0.5 * z * z), -0.5, 0.5);
      }
      value_[n] = z;
    }
  }
  double operator()(std::uint32_t bits) const {
    const std::uint32_t n = bits >> 20;
    const double rest = double(bits & 0xfffff) * 0x1p-20;
    return value_[n] + rest * (value_[n + 1] - value_[n]);
  }

 private:
  static constexpr int kIntervals = 4096;
  std::array<double, kIntervals + 1> value_;
};

const NormalTable& normal_table() {
  static const NormalTable table;
  return table;
}

constexpr int kPad = 4;  // columns of substrate on either side

// Mean surface of the fine rows under the spot's extent in y: fine column a has index a + kPad.
std::vector<double> row_under_spot(const Field& f, double y_mm, double spot_mm) {
  std::vector<double> line(std::size_t(f.width() + 2 * kPad), 0.0);
  const double v = (y_mm - f.bottom_mm()) / f.dy_mm(), half = 0.5 * spot_mm / f.dy_mm();
  const int first = std::max(0, int(std::floor(v - half))),
            last = std::min(f.height() - 1, int(std::floor(v + half)));
  double covered = 0.0;
  for (int b = first; b <= last; ++b) {
    const double weight = half > 0.0 ? std::min(v + half, b + 1.0) - std::max(v - half, double(b)) : 1.0;
    if (!(weight > 0.0)) continue;
    covered += weight;
    for (int a = 0; a < f.width(); ++a)
      line[std::size_t(a + kPad)] += weight * f.surface_mm(std::size_t(b) * f.width() + a);
  }
  if (covered > 0.0)
    for (double& z : line) z /= covered;
  return line;
}

}  // namespace

void measure_profile(const Field& f, const SensorParams& p, ProfileKey key, double y_mm, double x0_mm,
                     double dx_mm, std::span<double> z_mm) {
  const std::vector<double> line = row_under_spot(f, y_mm, p.spot_y_mm);
  const NormalTable& normal = normal_table();
  const bool steps = f.fine_cells() == 1;
  const std::array<std::uint32_t, 2> seed{std::uint32_t(key.seed), std::uint32_t(key.seed >> 32)};
  const auto block = [&](Purpose purpose, std::size_t n) {
    return philox4x32({std::uint32_t(n), key.trigger, key.layer, std::uint32_t(purpose)}, seed);
  };
  const double offset = p.offset_noise_mm > 0.0
                            ? p.offset_noise_mm * normal(block(Purpose::kSensorNoise, 0xffffffffu)[0])
                            : 0.0;
  const double per_cell = 1.0 / f.dx_mm(), half_slope = 0.5 * per_cell;
  const double quarter =
      p.spot_x_mm / (2.0 * std::sqrt(3.0)) * per_cell;  // two Gauss points represent the spot
  const double low_end = -2.0, high_end = f.width() + 2.0;
  const double middle_mm = f.left_mm() + 0.5 * f.width() * f.dx_mm();
  const auto floor_of = [](double u) { return int(u + kPad) - kPad; };
  PhiloxBlock noise{}, gap{};
  for (std::size_t n = 0; n < z_mm.size(); ++n) {
    if (n % 4 == 0) noise = block(Purpose::kSensorNoise, n / 4);
    if (n % 8 == 0) gap = block(Purpose::kDropout, n / 8);
    const double u = (x0_mm + double(n) * dx_mm - f.left_mm()) * per_cell;  // in fine cells
    double z = 0.0, slope = 0.0;
    if (steps) {
      z = line[std::size_t(floor_of(std::clamp(u, low_end, high_end)) + kPad)];
    } else {
      for (const double at : {u - quarter - 0.5, u + quarter - 0.5}) {
        const double held = std::clamp(at, low_end, high_end);
        const int cell = floor_of(held);
        const double low = line[std::size_t(cell + kPad)], step = line[std::size_t(cell + kPad + 1)] - low;
        z += 0.5 * (low + (held - cell) * step);
        slope += half_slope * step;
      }
    }
    const double dropout =
        p.dropout_floor + p.dropout_per_slope * std::max(0.0, std::abs(slope) - p.dropout_slope_from);
    const double draw = ((gap[n % 8 / 2] >> 16 * (n % 2) & 0xffffu) + 0.5) * 0x1p-16;
    z_mm[n] = draw < dropout ? std::numeric_limits<double>::quiet_NaN()
                             : z + offset + p.tilt * (x0_mm + double(n) * dx_mm - middle_mm) +
                                   p.noise_mm * normal(noise[n % 4]);
  }
}

}  // namespace firn::plant
