#include "procs/scheduler/sensor_check.h"

#include <cmath>

#include "core/grid/outline_shift.h"

namespace firn {
namespace {

constexpr double kMinCells = 10.0;
constexpr double kReach = 5.0;     // of the limit: a larger shift is found as one of at least so much
constexpr double kMinGain = 0.25;  // of the squared residual
constexpr double kShown = 0.4;     // of an offset, by edges of readings on the part alone
constexpr double kSure = 6.0;      // standard errors: neighbours are not independent

double length_mm(double x_mm, double y_mm) { return std::sqrt(x_mm * x_mm + y_mm * y_mm); }

}  // namespace

Violation check_bare(const HeightMap& bare, double limit_mm, const SensorWords& words) {
  double sum = 0.0, cells = 0.0;
  for (const double h : bare.cells) {
    if (!std::isfinite(h)) continue;
    sum += h;
    cells += 1.0;
  }
  if (limit_mm <= 0.0 || cells < kMinCells || std::abs(sum / cells) <= limit_mm) return {};
  return {words.what + " measures " + std::to_string(sum / cells) + " mm on average, 0 within " +
              std::to_string(limit_mm) + " mm is calibrated: " + words.culprits + "; " + words.calibrate,
          {sum / cells, limit_mm, "mm", words.key}};
}

Violation check_outline(const HeightMap& rise, const Mask& laid, const Mask& beside, double limit_mm,
                        const SensorWords& words) {
  if (limit_mm <= 0.0) return {};
  const OutlineShift s = outline_shift(rise, laid, beside, kReach * limit_mm);
  if (!s.known || s.gain < kMinGain || s.x_mm * s.x_mm + s.y_mm * s.y_mm <= limit_mm * limit_mm) return {};
  return {words.what + " lies (" + std::to_string(s.x_mm) + ", " + std::to_string(s.y_mm) +
              ") mm aside of its outline, at most " + std::to_string(limit_mm) +
              " mm is calibrated: " + words.culprits + "; " + words.calibrate,
          {length_mm(s.x_mm, s.y_mm), limit_mm, "mm", words.key}};
}

Violation check_edges(const HeightMap& rise, double limit_mm, const SensorWords& words) {
  if (limit_mm <= 0.0) return {};
  const EdgeGap gap = edge_gap(rise);
  const auto is_low = [&](double value_mm, double std_mm) {
    return std::abs(value_mm) > kShown * limit_mm && std::abs(value_mm) > kSure * std_mm;
  };
  if (!gap.known || (!is_low(gap.x_mm, gap.x_std_mm) && !is_low(gap.y_mm, gap.y_std_mm))) return {};
  return {words.what + " lies aside of its outline: its edges differ by (" + std::to_string(gap.x_mm) + ", " +
              std::to_string(gap.y_mm) + ") mm of ground without rise, at most " + std::to_string(limit_mm) +
              " mm of offset is calibrated: " + words.culprits + "; " + words.calibrate,
          {length_mm(gap.x_mm, gap.y_mm), limit_mm, "mm", words.key}};
}

}  // namespace firn
