// NextLevel computes distances of consecutive points from the next level of rings.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/region.h"
#include "core/geometry/rtree.h"
#include "core/slice/medial/medial_axis.h"

namespace firn::slice {

/// Keeps its working memory.
class NextLevel : public ClearanceField {
 public:
  /// @param rings kept by reference
  /// @param reach of the level's beads to each side
  void take(const geometry::Rings& rings, double reach);
  bool empty() const { return points_.empty(); }

  /// Returns whether the level is within `limit`. Rings run side by side, so the edge nearest to the last
  /// point is tried first.
  bool within(geometry::Vec p, double limit);
  /// Returns whether the level is within `limit` of all points from a, which is within the limit of the last
  /// edge found, to b. The distance from a segment is convex along a line: an edge that is near a and near
  /// the projection of a corner is near all points between them, and the next edge at the corner continues.
  bool way_within(geometry::Vec a, geometry::Vec b, double limit);
  double clearance(geometry::Vec p, double limit) override;
  /// Moves a point to the nearest one of the level. @return false if that is beyond the limit
  bool snap(geometry::Vec& p, double limit);

 private:
  // Returns the nearest point of an edge.
  geometry::Vec nearest(std::size_t edge, geometry::Vec p) const {
    const geometry::Vec at = to_vec(points_[edge]), way = to_vec(points_[following_[edge]]) - at;
    const double inverse = 1 / std::max(dot(way, way), 1.0);  // coordinates are integers
    return at + std::min(1.0, std::max(0.0, dot(p - at, way) * inverse)) * way;
  }
  double square_distance(std::size_t edge, geometry::Vec p) const {  // without branches
    const geometry::Vec at = to_vec(points_[edge]), way = to_vec(points_[following_[edge]]) - at,
                        off = p - at;
    const double square = dot(way, way), inverse = 1 / std::max(square, 1.0);  // coordinates are integers
    const double share = std::min(1.0, std::max(0.0, dot(off, way) * inverse));
    const geometry::Vec from = off - share * way;
    return dot(from, from);
  }

  template <class F>
  void touching(geometry::Vec p, double reach, F&& f);

  double reach_ = 0;
  const geometry::Rings* rings_ = nullptr;
  std::span<const geometry::Point> points_;  // edge i begins at point i
  std::vector<std::uint32_t> following_;     // in its ring
  std::size_t last_ = 0;
  geometry::Vec lonely_;  // points within the root of lonely_square_ of it are beyond the limit
  double lonely_square_ = 0;
  geometry::StaticRTree tree_;
  bool built_ = false;
};

}  // namespace firn::slice
