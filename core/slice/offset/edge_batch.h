// EdgeBatch finds the nearest one of the edges along one side of a cusp, two at a time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/lanes.h"
#include "core/geometry/vec.h"

namespace firn::slice {

/// Not a search structure: the R-tree finds the edges, and the batch computes their distances from many
/// points. Keeps its working memory.
class EdgeBatch {
 public:
  void clear() { count_ = 0; }
  bool empty() const { return count_ == 0; }
  /// Adds those of eight edges, from points [first, first + 8) to their `next` ones, that have a bit in
  /// `which` and whose direction is along `along`, more than along `other`.
  void add(std::span<const geometry::Point> points, const std::uint32_t* next, std::size_t first,
           unsigned which, geometry::Vec along, geometry::Vec other) {
    if (pairs_.size() < count_ + 4) pairs_.resize(2 * count_ + 4);
    Pair* pair = pairs_.data() + count_;
    for (; which; which >>= 2, first += 2) {
      if (!(which & 3)) continue;
      const std::size_t second = std::min(first + 1, points.size() - 1);
      const geometry::Point from[] = {points[first], points[second]},
                            to[] = {points[next[first]], points[next[second]]};
      const geometry::Lanes2 x = x_of(from), y = y_of(from), way_x = x_of(to) - x, way_y = y_of(to) - y;
      const geometry::Lanes2 ahead = way_x * along.x + way_y * along.y;
      const unsigned taken = which & unsigned(geometry::lanes_of(ahead > geometry::Lanes2{}) &
                                              geometry::lanes_of(ahead > way_x * other.x + way_y * other.y));
      if (!taken) continue;
      *pair = {x, y, way_x, way_y, 1 / (way_x * way_x + way_y * way_y)};
      if (!(taken & 1)) pair->x[0] = kNowhere;
      if (!(taken & 2)) pair->x[1] = kNowhere;
      ++pair;
    }
    count_ = std::size_t(pair - pairs_.data());
  }
  /// Returns the vector to p from its nearest point; of equally near edges the one added first decides.
  geometry::Vec way_to(geometry::Vec p) const {
    geometry::Lanes2 least = {kFurthest, kFurthest};
    geometry::Held2 found = {0, 1}, here = found;
    for (const Pair *e = pairs_.data(), *const end = e + count_; e != end; ++e) {
      const Vec2 way = e->way_to(p);
      const geometry::Lanes2 square = way.x * way.x + way.y * way.y;
      const geometry::Held2 nearer = square < least;
      least = nearer ? square : least;
      found = nearer ? here : found;
      here += 2;
    }
    const bool second = least[1] < least[0] || (least[1] == least[0] && found[1] < found[0]);
    const Vec2 way = pairs_[std::size_t(found[second]) / 2].way_to(p);
    return {way.x[second], way.y[second]};
  }

 private:
  struct Vec2 {
    geometry::Lanes2 x, y;
  };
  struct Pair {
    geometry::Lanes2 x, y, way_x, way_y, inverse;  // inverse: of the squared length
    Vec2 way_to(geometry::Vec p) const {
      const geometry::Lanes2 off_x = p.x - x, off_y = p.y - y;
      constexpr geometry::Lanes2 kEnd = {1, 1};
      geometry::Lanes2 along = (off_x * way_x + off_y * way_y) * inverse;
      along = along < geometry::Lanes2{} ? geometry::Lanes2{} : along;
      along = kEnd < along ? kEnd : along;
      return {off_x - along * way_x, off_y - along * way_y};
    }
  };
  static geometry::Lanes2 x_of(const geometry::Point (&p)[2]) {
    return geometry::Lanes2{double(p[0].x), double(p[1].x)};
  }
  static geometry::Lanes2 y_of(const geometry::Point (&p)[2]) {
    return geometry::Lanes2{double(p[0].y), double(p[1].y)};
  }
  static constexpr double kNowhere = 1e200, kFurthest = 1e300;  // squared distances of absent edges exceed it
  std::vector<Pair> pairs_;                                     // the first count_
  std::size_t count_ = 0;
};

}  // namespace firn::slice
