// The rings of a concentric fill, each the exact offset of the original outline [Barnett, 3.4, 3.5].
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/region.h"
#include "core/geometry/stretches.h"
#include "core/slice/ring_plan.h"

namespace firn::slice {

/// What of one level (or the outline) lacks the next one.
struct LevelGaps {
  bool told = false;   ///< else the front could not tell, and the rings are to be asked
  Stretches of_rings;  ///< of the level itself
  Stretches of_cores;  ///< of the level's cores (RingPlan::core_mm), where it bounds areas about too narrow
                       ///< for the next one
};

struct RingLevels {
  std::vector<Rings>
      levels;  ///< [k]: all rings at distance_mm(k), directed as in a Region, in no canonical order
  std::uint32_t from_clipper = 0;  ///< levels that Clipper made, because the wavefront could not tell
  std::vector<bool> touching;      ///< [k]: rings of the level may have contacts with each other
  std::vector<LevelGaps>
      gaps;  ///< [k]: between level k - 1 and k, if asked for; as many levels and one, or plan.max_rings
  std::uint32_t drawn_finer = 0;  ///< levels whose rings would have met each other at the asked tolerance
};

/// Where a region comes from, if its outline was thinned.
struct Thinned {
  const Rings* from = nullptr;  ///< contours; null or empty: not known, or the region is what it is
  double by_mm = 0;             ///< the two differ by no more
  bool whole = false;           ///< all of them bound the region, and nothing else does
};

/// Memory that offset_rings() keeps from region to region.
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

/// @param tolerance_mm no ring leaves the exact offset of `region` by more than this; 0: arcs by 1 um, no
/// point left out
/// @param spot_mm diameter of the spots between levels that are looked for; 0: none
RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm,
                        const Thinned& thinned, OffsetWork& work);
RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm = 0,
                        const Thinned& thinned = {});

/// The region grown outward by a distance > 0, as the front of what lies around it.
Region grow(const Region& region, double outward_mm, double tolerance_mm);

}  // namespace firn::slice
