// The front of some areas of a region on its way inward, level by level.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/meeting.h"
#include "core/slice/medial/gap_band.h"
#include "core/slice/offset/exact_tips.h"
#include "core/slice/offset/lacks.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice {

/// Keeps its working memory. Distances in units.
class Advance {
 public:
  using Areas =
      std::span<const std::vector<std::uint32_t>>;  ///< outer rings of a region, each with its holes

  /// @param thinned units by which the region may differ from what it was thinned from
  void begin(const Region& region, Areas areas, double thinned = 0);
  /// @return false if the wavefront could not tell
  bool operator()(double to);
  /// The same; tells what of the front lacks the next one. Components whose rings, as drawn last, look too
  /// narrow for the next ones are looked at on the way.
  /// @param core where, or beyond `to`: none are
  /// @param drawn what draw() has been given last
  bool telling(double core, double to, const Rings& drawn, const GapLimits& limits,
               const GapLimits& core_limits, double sagitta, LevelGaps& gaps);
  /// At the asked tolerance, or finer where rings would meet; where they do with their tips in exact places,
  /// without these, which then have failed. @return false if they meet even so
  bool draw(double tolerance, ExactTips* tips, Rings& rings, std::uint32_t& finer);
  std::size_t loops();                         ///< of the front; those smaller than the grid are not drawn
  bool touching() const { return touching_; }  ///< may the rings drawn last have contacts?

 private:
  bool move(wavefront::Component& component, double from, double to, wavefront::Components& out);
  bool move_telling(wavefront::Component& component, double from, double to, const GapLimits& limits,
                    double sagitta, Stretches& stretches);
  void arrive(double to);
  void doubt_meeting(const Rings& rings, ExactTips& tips) const;
  static bool looks_narrow(const Rings& rings, std::size_t begin, std::size_t end, double width);

  std::vector<wavefront::Source> sources_;
  wavefront::Components here_, next_, cores_;
  double at_ = 0, thinned_ = 0;
  bool touching_ = false;
  wavefront::Mover move_;
  wavefront::Untangler untangle_;
  wavefront::Lacks lacks_;
  wavefront::Drawer draw_;
  MeetingCheck meeting_;
  std::vector<std::size_t> drawn_ends_;  // rings of each component and those before it
};

}  // namespace firn::slice
