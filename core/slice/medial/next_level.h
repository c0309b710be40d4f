// The next level of rings, asked for its distance by places that follow each other.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/box_search.h"
#include "core/slice/medial/middle_lines.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// Keeps its working memory.
class NextLevel : public AxisField {
 public:
  /// @param rings kept by reference
  /// @param reach of the level's beads to each side
  void take(const Rings& rings, double reach);
  bool empty() const { return points_.empty(); }

  /// Is the level no further than this? Rings run side by side: the edge that was near the last place is a
  /// guess.
  bool within(Vec p, double limit);
  /// Is it so all the way from a, which is within the limit of the edge found last, to b? The distance from a
  /// segment is convex along a line: an edge that is near a and a corner's foot on the way is near all
  /// between, and the corner's next edge goes on.
  bool way_within(Vec a, Vec b, double limit);
  double clearance(Vec p, double limit) override;
  /// Moves a place to the level's nearest one. @return false if that is further than the limit
  bool snap(Vec& p, double limit);

 private:
  // Of the edge's places the nearest.
  Vec nearest(std::size_t edge, Vec p) const {
    const Vec at = to_vec(points_[edge]), way = to_vec(points_[following_[edge]]) - at;
    const double inverse = 1 / std::max(dot(way, way), 1.0);  // in whole units
    return at + std::min(1.0, std::max(0.0, dot(p - at, way) * inverse)) * way;
  }
  double square_distance(std::size_t edge, Vec p) const {  // without a branch
    const Vec at = to_vec(points_[edge]), way = to_vec(points_[following_[edge]]) - at, off = p - at;
    const double square = dot(way, way), inverse = 1 / std::max(square, 1.0);  // in whole units
    const double share = std::min(1.0, std::max(0.0, dot(off, way) * inverse));
    const Vec from = off - share * way;
    return dot(from, from);
  }

  template <class F>
  void touching(Vec p, double reach, F&& f);

  double reach_ = 0;
  const Rings* rings_ = nullptr;
  std::span<const Point> points_;         // edge i begins at point i
  std::vector<std::uint32_t> following_;  // in its ring
  std::size_t last_ = 0;
  Vec lonely_;  // nothing is within the limit of places nearer to it than the root of
  double lonely_square_ = 0;
  BoxSearch tree_;
  bool built_ = false;
};

}  // namespace firn::slice
