// GapDetector finds coverage gaps: parts of the wavefront at one distance without a wavefront near them at
// the next.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/boundary_chains.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {

/// Maximum distances between a point of the wavefront and the next wavefront without a gap between them.
struct CoverageGapLimits {
  double near = 0;         ///< of any point
  double far = 0;          ///< of all points of a cornered chain
  double near_corner = 0;  ///< of a corner of two sides from the next wavefront along them
  double slack = 0;        ///< points so far outside such a corner count as inside
  double narrowest = 0;    ///< loops around narrower areas have no gap
};

/// Wavefront edges that survive run parallel to their previous positions. The edges that collapsed between
/// two of them lie, with the traces of the ends of these, about one corner of the next wavefront. If all
/// their corners are near that corner, all of their points are: the distance from a point is convex along a
/// line, and arcs bulge towards it.
///
/// A chain is cornered if its two surviving neighbours are now adjacent. Let P be the corner in which they
/// meet. The segments from P back to these two edges lie in the area that they swept. The area between the
/// segments was swept by the edges of the chain alone, unless a hole with its whole loop vanished there. Any
/// path from there to the next wavefront either crosses one of the segments in a point z, from which no point
/// of the next wavefront is nearer than P (the depth of z is less than that of P by their distance), or
/// leaves the area: P is the nearest point of the next wavefront. Keeps its working memory.
class GapDetector {
 public:
  /// Stores a component before it moves on from distance `d`.
  void keep(const Component& component, double d);
  /// Appends the chains of the stored component that have a gap.
  /// @param out the components that it has become
  /// @param sagitta of the chords of arcs
  void find(std::span<const Site> sites, std::span<const Component> out, const CoverageGapLimits& limits,
            double sagitta, geometry::BoundaryChains& chains);

 private:
  struct Kept {
    std::int32_t site;
    geometry::Vec from;
  };
  struct Ahead {  // an edge of the next wavefront
    geometry::Vec from;
    std::int32_t site, next;
  };
  static constexpr std::int32_t kGone = -1, kSeveral = -2;

  void find_in(std::span<const Kept> loop, const CoverageGapLimits& limits, double sagitta,
               geometry::BoundaryChains& chains);
  bool covered(std::span<const Kept> loop, std::size_t i, std::size_t steps,
               const CoverageGapLimits& limits) const;
  bool cornered(std::span<const Kept> loop, std::size_t i, std::size_t steps) const;
  bool blunt(std::span<const Kept> loop, std::size_t i, std::size_t steps, geometry::Vec corner,
             const CoverageGapLimits& limits) const;
  void add_chain(std::span<const Kept> loop, std::size_t i, std::size_t steps, double sagitta,
                 geometry::BoundaryChains& chains);
  void add_all(std::span<const Kept> loop, const CoverageGapLimits& limits, double sagitta,
               geometry::BoundaryChains& chains) const;
  geometry::Vec beside(const Kept& edge, geometry::Vec ahead) const;
  void add_arc(const Kept& edge, geometry::Vec a, geometry::Vec b, double sagitta,
               std::vector<geometry::Vec>& points) const;

  std::span<const Site> sites_;
  double d_ = 0;
  std::vector<Kept> kept_;
  std::vector<std::uint32_t> ends_;
  std::vector<std::int32_t> at_;  // [site]: its edge of the next wavefront
  std::vector<Ahead> ahead_;
  bool loop_vanished_ = false;
};

}  // namespace firn::slice::wavefront
