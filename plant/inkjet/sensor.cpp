#include "plant/inkjet/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/grid/avx2.h"
#include "core/grid/random.h"
#include "core/grid/random_normals.h"

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
    const double rest = double(int(bits & 0xfffff)) * 0x1p-20;
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

constexpr std::size_t kAtOnce = 128;  // points

/// Row of the fine field seen through the spot, and where a point lies on it.
struct SeenRow {
  const double* line;
  double x0_mm, dx_mm, left_mm, per_cell, quarter, low_end, high_end;
  bool steps;
};

FIRN_INLINE double held_within(double u, double low, double high) {
  const double v = u < low ? low : u;
  return high < v ? high : v;
}
FIRN_INLINE int floor_of(double u) { return int(u + kPad) - kPad; }

/// Heights and slopes of points [first, first + kAtOnce). Two Gauss points represent the spot.
template <bool kSteps>
FIRN_INLINE void see(const SeenRow& row, std::size_t first, double* z, double* slope) {
  const double half_slope = 0.5 * row.per_cell;
  for (std::size_t n = 0; n < kAtOnce; ++n) {
    const double u = (row.x0_mm + double(int(first + n)) * row.dx_mm - row.left_mm) * row.per_cell;
    if constexpr (kSteps) {
      z[n] = row.line[floor_of(held_within(u, row.low_end, row.high_end)) + kPad];
      slope[n] = 0.0;
    } else {
      const double a = held_within(u - row.quarter - 0.5, row.low_end, row.high_end),
                   b = held_within(u + row.quarter - 0.5, row.low_end, row.high_end);
      const int i = floor_of(a), j = floor_of(b);
      const double low_a = row.line[i + kPad], step_a = row.line[i + kPad + 1] - low_a;
      const double low_b = row.line[j + kPad], step_b = row.line[j + kPad + 1] - low_b;
      z[n] = 0.0 + 0.5 * (low_a + (a - i) * step_a) + 0.5 * (low_b + (b - j) * step_b);
      slope[n] = 0.0 + half_slope * step_a + half_slope * step_b;
    }
  }
}

/// Random words of kAtOnce points, and their heights as read.
struct Draws {
  std::array<PhiloxBlock, kAtOnce / 4> noise;
  std::array<PhiloxBlock, kAtOnce / 8> gap;
};
FIRN_CLONES void read_points(const SeenRow& row, const SensorParams& p, double offset, double middle_mm,
                             std::size_t first, const Draws& draws, double* z_mm) {
  double z[kAtOnce], slope[kAtOnce], noise[kAtOnce], draw[kAtOnce];
  if (row.steps)
    see<true>(row, first, z, slope);
  else
    see<false>(row, first, z, slope);
  const NormalTable& normal = normal_table();
  for (std::size_t n = 0; n < kAtOnce; ++n) noise[n] = normal(draws.noise[n / 4][n % 4]);
  for (std::size_t n = 0; n < kAtOnce; n += 2) {  // two points a word
    const std::uint32_t word = draws.gap[n / 8][n % 8 / 2];
    draw[n] = (int(word & 0xffffu) + 0.5) * 0x1p-16;
    draw[n + 1] = (int(word >> 16) + 0.5) * 0x1p-16;
  }
  for (std::size_t n = 0; n < kAtOnce; ++n) {
    const double steep = std::abs(slope[n]) - p.dropout_slope_from;
    const double dropout = p.dropout_floor + p.dropout_per_slope * (0.0 < steep ? steep : 0.0);
    const double read = p.scale * z[n] + offset +
                        p.tilt * (row.x0_mm + double(int(first + n)) * row.dx_mm - middle_mm) +
                        p.noise_mm * noise[n];
    z_mm[n] = draw[n] < dropout ? std::numeric_limits<double>::quiet_NaN() : read;
  }
}

// First-order autoregression along the profile, of standard deviation wave_mm. Its draws are those of blocks
// of noise beyond all points of a profile.
constexpr std::uint32_t kWaveBlocks = 0x40000000u;
void add_wave(const SensorParams& p, double dx_mm, PhiloxBlock first, std::array<std::uint32_t, 2> seed,
              std::span<double> z_mm) {
  const double kept = std::exp(-dx_mm / p.wave_length_mm), fresh = std::sqrt(1.0 - kept * kept);
  double wave = 0.0;
  PhiloxBlock block{};
  for (std::size_t n = 0; n < z_mm.size(); ++n) {
    if (n % 4 == 0) {
      first[0] = kWaveBlocks + std::uint32_t(n / 4);
      block = philox4x32(first, seed);
    }
    const double draw = normal_table()(block[n % 4]);
    wave = n == 0 ? draw : kept * wave + fresh * draw;
    z_mm[n] += p.wave_mm * wave;
  }
}

// Raises readings beside a higher edge by a share of the step.
void add_ghosts(const SensorParams& p, double dx_mm, std::span<double> z_mm) {
  const std::vector<double> seen(z_mm.begin(), z_mm.end());
  const auto reach = std::int64_t(p.ghost_reach_mm / dx_mm), count = std::int64_t(seen.size());
  for (std::int64_t n = 0; n < count; ++n) {
    double top = seen[std::size_t(n)];
    for (std::int64_t k = std::max<std::int64_t>(0, n - reach); k <= std::min(count - 1, n + reach); ++k)
      if (seen[std::size_t(k)] > top) top = seen[std::size_t(k)];  // false for a reading that is missing
    const double step_mm = top - seen[std::size_t(n)];
    if (step_mm >= p.ghost_step_mm) z_mm[std::size_t(n)] += p.ghost_share * step_mm;
  }
}

}  // namespace

void measure_profile(const Field& f, const SensorParams& p, ProfileKey key, double y_mm, double x0_mm,
                     double dx_mm, std::span<double> z_mm) {
  const std::vector<double> line = row_under_spot(f, y_mm, p.spot_y_mm);
  const std::array<std::uint32_t, 2> seed{std::uint32_t(key.seed), std::uint32_t(key.seed >> 32)};
  const auto counter = [&](Purpose purpose, std::size_t n) {
    return PhiloxBlock{std::uint32_t(n), key.trigger, key.layer, std::uint32_t(purpose)};
  };
  const double offset = p.offset_noise_mm > 0.0
                            ? p.offset_noise_mm * normal_table()(philox4x32(
                                                      counter(Purpose::kSensorNoise, 0xffffffffu), seed)[0])
                            : 0.0;
  const double per_cell = 1.0 / f.dx_mm(), middle_mm = f.left_mm() + 0.5 * f.width() * f.dx_mm();
  const SeenRow row{line.data(), x0_mm,           dx_mm,
                    f.left_mm(), per_cell,        p.spot_x_mm / (2.0 * std::sqrt(3.0)) * per_cell,
                    -2.0,        f.width() + 2.0, f.fine_cells() == 1};
  Draws draws;
  double z[kAtOnce];
  for (std::size_t first = 0; first < z_mm.size(); first += kAtOnce) {
    philox_blocks(counter(Purpose::kSensorNoise, first / 4), seed, draws.noise);
    philox_blocks(counter(Purpose::kDropout, first / 8), seed, draws.gap);
    read_points(row, p, offset, middle_mm, first, draws, z);
    std::copy_n(z, std::min(kAtOnce, z_mm.size() - first), z_mm.begin() + std::ptrdiff_t(first));
  }
  if (p.wave_mm > 0.0) add_wave(p, dx_mm, counter(Purpose::kSensorNoise, 0), seed, z_mm);
  if (p.ghost_share > 0.0) add_ghosts(p, dx_mm, z_mm);
}

}  // namespace firn::plant
