// offset_rings() computes the rings of a concentric fill, each the exact offset of the original outline
// [Barnett, 3.4, 3.5].
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/boundary_chains.h"
#include "core/geometry/region.h"
#include "core/slice/ring_plan.h"

namespace firn::slice {

/// Chains of one level (or the outline) from which the next level is too far away.
struct LevelGaps {
  bool known = false;  ///< else the wavefront was ambiguous, and the drawn rings must be scanned
  geometry::BoundaryChains of_rings;  ///< of the level itself
  /// Of the eroded cores of the level (RingPlan::eroded_core_mm), where it bounds areas about too narrow for
  /// the next one.
  geometry::BoundaryChains of_eroded_cores;
};

struct RingLevels {
  /// [k]: all rings at distance_mm(k), directed as in a Region, in no canonical order.
  std::vector<geometry::Rings> levels;
  std::uint32_t from_clipper = 0;  ///< levels computed by Clipper, because the wavefront was ambiguous
  std::vector<bool> touching;      ///< [k]: rings of the level may have contacts with each other
  /// [k]: between level k - 1 and k, if requested; one more than levels, or plan.max_rings.
  std::vector<LevelGaps> gaps;
  std::uint32_t drawn_finer = 0;  ///< levels whose rings would have intersected at the requested tolerance
};

/// The contours from which the outline of a region was simplified.
struct Simplified {
  const geometry::Rings* from = nullptr;  ///< null or empty: unknown, or the region is not simplified
  double by_mm = 0;                       ///< maximum distance between the two
  bool whole = false;                     ///< the region is bounded by all of them and by nothing else
};

/// Working memory that offset_rings() keeps from region to region.
class OffsetWork {
 public:
  OffsetWork();
  ~OffsetWork();
  OffsetWork(OffsetWork&&) noexcept;
  OffsetWork& operator=(OffsetWork&&) noexcept;
  struct State;
  State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

/// @param tolerance_mm maximum distance of a ring from the exact offset of `region`; 0: arcs within 1 um, all
/// points kept
/// @param void_mm diameter of the voids between levels that are searched for; 0: no search
RingLevels offset_rings(const geometry::Region& region, const RingPlan& plan, double tolerance_mm,
                        double void_mm, const Simplified& simplified, OffsetWork& work);
RingLevels offset_rings(const geometry::Region& region, const RingPlan& plan, double tolerance_mm,
                        double void_mm = 0, const Simplified& simplified = {});

/// Returns the region grown outward by a distance > 0, computed as the wavefront of its surroundings.
geometry::Region grow(const geometry::Region& region, double outward_mm, double tolerance_mm);

}  // namespace firn::slice
