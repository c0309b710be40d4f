#include "plant/sensor.h"

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

// Mean surface of the fine rows under the spot's extent in y, one value per fine column.
std::vector<double> row_under_spot(const Field& f, double y_mm, double spot_mm) {
  std::vector<double> line(f.width(), 0.0);
  const double v = (y_mm - f.bottom_mm()) / f.dy_mm(), half = 0.5 * spot_mm / f.dy_mm();
  const int first = std::max(0, int(std::floor(v - half))), last = std::min(f.height() - 1, int(std::floor(v + half)));
  double covered = 0.0;
  for (int b = first; b <= last; ++b) {
    const double weight = half > 0.0 ? std::min(v + half, b + 1.0) - std::max(v - half, double(b)) : 1.0;
    if (!(weight > 0.0)) continue;
    covered += weight;
    for (int a = 0; a < f.width(); ++a) line[a] += weight * f.surface_mm(std::size_t(b) * f.width() + a);
  }
  if (covered > 0.0)
    for (double& z : line) z /= covered;
  return line;
}

}  // namespace

void measure_profile(const Field& f, const SensorParams& p, ProfileKey key, double y_mm, double x0_mm, double dx_mm,
                     std::span<double> z_mm) {
  const std::vector<double> line = row_under_spot(f, y_mm, p.spot_y_mm);
  const NormalTable& normal = normal_table();
  const bool steps = f.fine_cells() == 1;
  const int width = f.width();
  const auto at = [&](int a) { return a >= 0 && a < width ? line[a] : 0.0; };
  const std::array<std::uint32_t, 2> seed{std::uint32_t(key.seed), std::uint32_t(key.seed >> 32)};
  const auto block = [&](Purpose purpose, std::size_t n) {
    return philox4x32({std::uint32_t(n), key.trigger, key.layer, std::uint32_t(purpose)}, seed);
  };
  const double offset = p.offset_noise_mm > 0.0
      ? p.offset_noise_mm * normal(block(Purpose::kSensorNoise, 0xffffffffu)[0]) : 0.0;
  const double quarter = p.spot_x_mm / (2.0 * std::sqrt(3.0));  // two Gauss points stand for the spot
  PhiloxBlock noise{}, gap{};
  for (std::size_t n = 0; n < z_mm.size(); ++n) {
    const std::size_t lane = n % 4;
    if (lane == 0) noise = block(Purpose::kSensorNoise, n / 4), gap = block(Purpose::kDropout, n / 4);
    const double x = x0_mm + double(n) * dx_mm;
    double z = 0.0, slope = 0.0;
    if (steps) {
      z = at(int(std::floor((x - f.left_mm()) / f.dx_mm())));
    } else {
      for (const double u : {(x - quarter - f.left_mm()) / f.dx_mm() - 0.5, (x + quarter - f.left_mm()) / f.dx_mm() - 0.5}) {
        const double cell = std::floor(u);
        const double low = at(int(cell)), high = at(int(cell) + 1);
        z += 0.5 * (low + (u - cell) * (high - low));
        slope += 0.5 * (high - low) / f.dx_mm();
      }
    }
    const double dropout =
        p.dropout_floor + p.dropout_per_slope * std::max(0.0, std::abs(slope) - p.dropout_slope_from);
    z_mm[n] = double(gap[lane]) * 0x1p-32 < dropout ? std::numeric_limits<double>::quiet_NaN()
                                                    : z + offset + p.noise_mm * normal(noise[lane]);
  }
}

}  // namespace firn::plant
