#include "core/slice/medial/gap_band.h"

#include <algorithm>
#include <cmath>

namespace firn::slice {
namespace {

constexpr double kFootStep =
    0.3 * geometry::kUnitsPerMm;  // from the boundary sample of a void to the nearest one that is tested

}  // namespace

GapBand gap_band(const RingPlan& plan, int level) {
  if (level < 0) return {plan.first_mm - 0.5 * plan.width_mm(0), plan.first_mm};
  return {0.5 * plan.width_mm(level), plan.distance_mm(level + 1) - plan.distance_mm(level)};
}

GapBand eroded_core_band(const RingPlan& plan, int level, double void_mm) {
  const double eroded_core_mm = plan.eroded_core_mm(level, void_mm);
  return {-0.5 * void_mm, plan.distance_mm(level + 1) - eroded_core_mm,
          eroded_core_mm - plan.distance_mm(level)};
}

GapLimits gap_limits(const GapBand& band, double void_mm, double tolerance_mm) {
  const double narrowest = 0.5 * void_mm * geometry::kUnitsPerMm,
               tolerance = std::max(100.0, tolerance_mm * geometry::kUnitsPerMm);
  const double drawn = 2.2 * tolerance + 200;  // both levels are drawn within the tolerance
  GapLimits limits;
  limits.axis = {band.covered_mm * geometry::kUnitsPerMm, band.next_mm * geometry::kUnitsPerMm, narrowest,
                 drawn, band.inside_mm * geometry::kUnitsPerMm};
  limits.near = limits.near_corner = limits.axis.next + drawn;
  limits.far = std::max(limits.near, limits.axis.next + 2 * narrowest - drawn);
  limits.void_at = limits.axis.covered + narrowest;
  const double n = limits.axis.next + limits.axis.inside, c = limits.void_at + limits.axis.inside;
  if (n <= c || c < 0) return limits;
  const double d = limits.axis.next - limits.axis.covered + narrowest;
  const double least = std::sqrt(std::min(d * d, (n - c) * (n - c) + d * d * c / n));
  limits.enough = least - drawn - kFootStep;
  limits.slack = 0.02 * d;
  limits.near_corner = std::max(
      limits.near, (least - 2 * limits.slack) * limits.axis.next / (limits.axis.next - limits.void_at));
  return limits;
}

}  // namespace firn::slice
