// OffsetPropagator computes the offset curves of some areas of a region, level by level.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/intersection.h"
#include "core/slice/medial/gap_band.h"
#include "core/slice/offset/cusp_corrector.h"
#include "core/slice/offset/gap_detector.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice {

/// Keeps its working memory. Distances in units.
class OffsetPropagator {
 public:
  using Areas =
      std::span<const std::vector<std::uint32_t>>;  ///< outer rings of a region, each with its holes

  /// @param simplified maximum distance [units] between the region and the contours from which it was
  /// simplified
  void begin(const geometry::Region& region, Areas areas, double simplified = 0);
  /// Advances to distance `to`. @return false if the result is numerically ambiguous
  bool operator()(double to);
  /// As operator(), and finds the chains of the wavefront without a next level. Components whose rings, as
  /// drawn last, look too narrow for the next level are also examined at an intermediate distance.
  /// @param core the intermediate distance; beyond `to`: not used
  /// @param drawn the result of the last draw()
  bool advance_with_gaps(double core, double to, const geometry::Rings& drawn, const GapLimits& limits,
                         const GapLimits& core_limits, double sagitta, LevelGaps& gaps);
  /// Draws at the requested tolerance, or finer where rings would intersect. Where they intersect with
  /// corrected cusps, these are discarded, and the correction has failed. @return false if the rings
  /// intersect nevertheless
  bool draw(double tolerance, CuspCorrector* cusps, geometry::Rings& rings, std::uint32_t& finer);
  std::size_t loops();  ///< of the wavefront; loops smaller than the grid are not drawn
  bool touching() const { return touching_; }  ///< whether the rings drawn last may touch

 private:
  bool move(wavefront::Component& component, double from, double to, wavefront::Components& out);
  bool move_with_gaps(wavefront::Component& component, double from, double to, const GapLimits& limits,
                      double sagitta, geometry::BoundaryChains& chains);
  void arrive(double to);
  void mark_uncertain_contact(const geometry::Rings& rings, CuspCorrector& cusps) const;
  static bool looks_narrow(const geometry::Rings& rings, std::size_t begin, std::size_t end, double width);

  std::vector<wavefront::Site> sites_;
  wavefront::Components here_, next_, eroded_cores_;
  double at_ = 0, simplified_ = 0;
  bool touching_ = false;
  wavefront::Propagation propagate_;
  wavefront::SelfIntersectionTrimmer trim_;
  wavefront::GapDetector gap_detector_;
  wavefront::Drawer draw_;
  geometry::IntersectionCheck intersection_check_;
  std::vector<std::size_t> drawn_ends_;  // number of rings up to and including each component
};

}  // namespace firn::slice
