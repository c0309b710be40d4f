// StaticRTree finds the boxes of a list that meet a box, a disc or each other, and the nearest to a point.
//
// The tree is packed once in the order of the list; afterwards boxes can only be removed [after Guttman 1984,
// "R-trees: a dynamic index structure for spatial searching"; Kamel and Faloutsos 1993, "On packing
// R-trees"]. Queries are fast where neighbours in the list lie near each other, as the edges of an outline
// do.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/geometry/box.h"
#include "core/geometry/exact.h"
#include "core/geometry/region.h"

namespace firn::geometry {

/// Each node has eight children, whose coordinates lie side by side, so that all eight are compared at once.
/// Queries visit leaves in ascending order. The tree keeps its working memory.
class StaticRTree {
 public:
  using Box = BoxOf<std::int32_t>;

  /// All leaves must be set before build() is called.
  void resize(std::size_t leaves) {
    leaves_ = leaves;
    levels_[0].resize((leaves + kFan - 1) / kFan);
    for (std::size_t i = leaves; i < levels_[0].size() * kFan; ++i) put(levels_[0], i, kNowhere);
  }
  void set(std::size_t leaf, std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
    put(levels_[0], leaf, {x0, y0, -x1, -y1});
  }
  void set(std::size_t leaf, const Box& b) { set(leaf, b.x0, b.y0, b.x1, b.y1); }
  /// Sets one leaf per point: the box of the edge from the point to the next one of its ring.
  void set_rings(const Rings& rings) {
    const std::span<const Point> p = rings.points;
    resize(p.size());
    std::size_t i = 0;
    for (; i + 4 < p.size();
         i += 4) {  // as if all rings were one polyline; joins of rings are corrected below
      const Lanes a = two_points(&p[i]), b = two_points(&p[i + 2]), c = two_points(&p[i + 1]),
                  d = two_points(&p[i + 3]);
      const Lanes x = __builtin_shufflevector(a, b, 0, 2, 4, 6),
                  y = __builtin_shufflevector(a, b, 1, 3, 5, 7);
      const Lanes u = __builtin_shufflevector(c, d, 0, 2, 4, 6),
                  v = __builtin_shufflevector(c, d, 1, 3, 5, 7);
      Node& node = levels_[0][i / kFan];
      const std::size_t half = i % kFan / 4;
      node.lanes[0][half] = x < u ? x : u;
      node.lanes[1][half] = y < v ? y : v;
      node.lanes[2][half] = -(x > u ? x : u);
      node.lanes[3][half] = -(y > v ? y : v);
    }
    const auto join = [&](std::size_t leaf, Point from, Point to) {
      set(leaf, std::min(from.x, to.x), std::min(from.y, to.y), std::max(from.x, to.x),
          std::max(from.y, to.y));
    };
    for (; i + 1 < p.size(); ++i) join(i, p[i], p[i + 1]);
    std::size_t begin = 0;
    for (const std::uint32_t end : rings.ends) {
      if (end > begin) join(end - 1, p[end - 1], p[begin]);
      begin = end;
    }
  }

  void build() {
    depth_ = 1;
    while (levels_[depth_ - 1].size() > 1) {
      if (depth_ == levels_.size()) levels_.emplace_back();
      const std::vector<Node>& below = levels_[depth_ - 1];
      std::vector<Node>& here = levels_[depth_++];
      here.resize((below.size() + kFan - 1) / kFan);
      for (std::size_t i = 0; i < here.size() * kFan; ++i)
        put(here, i, i < below.size() ? least(below[i]) : kNowhere);
    }
  }

  /// Removes a leaf of the built tree: no query but pairs() finds it any more, and the boxes above it shrink.
  void remove(std::size_t leaf) {
    put(levels_[0], leaf, kNowhere);
    for (std::size_t level = 1; level < depth_; ++level) {
      leaf /= kFan;
      put(levels_[level], leaf, least(levels_[level - 1][leaf]));
    }
  }

  /// Calls f(i, j), i < j, for all pairs of leaves whose boxes meet.
  template <class F>
  void pairs(F&& f) const {
    if (leaves_ > 0) pairs_in(depth_ - 1, 0, f);
  }
  /// Calls f(i) for all leaves that meet a box.
  template <class F>
  void touching(const Box& b, F&& f) const {
    any_touching(b, [&](std::size_t i) {
      f(i);
      return false;
    });
  }
  /// Calls f(i, which) for each eight leaves [i, i + 8) of which some meet a box; `which` has a bit for each.
  template <class F>
  void eights_touching(const Box& b, F&& f) const {
    if (leaves_ == 0) return;
    const Query query(b);
    if (depth_ > 1)
      down_to_eights(depth_ - 1, 0, query, f);
    else if (const unsigned met = meeting(levels_[0][0], query))
      f(0, met);
  }
  /// As touching(), until f(i) returns true. @return whether it did
  template <class F>
  bool any_touching(const Box& b, F&& f) const {
    return leaves_ > 0 && down(depth_ - 1, 0, Query(b), f);
  }
  /// As any_touching(), for all leaves whose boxes are nearer to (x, y) than `distance`.
  template <class F>
  bool any_nearer(double x, double y, double distance, F&& f) const {
    return leaves_ > 0 && down_about({x, y, distance, Query(box_about(x, y, distance))}, depth_ - 1, 0, f);
  }
  /// Calls f(i) for leaves in ascending order of their distance from (x, y) [best-first search after
  /// Hjaltason and Samet 1999, "Distance browsing in spatial databases"].
  /// @param f returns the square of the distance beyond which leaves are of no interest; until then none is
  template <class F>
  void nearest(double x, double y, F&& f) {
    double limit = std::numeric_limits<double>::max();
    queue_.assign(leaves_ > 0, {0.0, std::uint32_t(depth_), 0});
    while (!queue_.empty() && queue_.front().square <= limit) {
      std::pop_heap(queue_.begin(), queue_.end());
      const Place at = queue_.back();
      queue_.pop_back();
      if (at.level == 0) {
        limit = f(at.index);
        continue;
      }
      const Node& node = levels_[at.level - 1][at.index];
      for (std::uint32_t child = 0; child < kFan; ++child) {
        const std::size_t half = child / 4, lane = child % 4;
        if (node.lanes[0][half][lane] > -node.lanes[2][half][lane]) continue;  // removed
        const double square = square_distance(node, child, x, y);
        if (square > limit) continue;
        queue_.push_back({square, at.level - 1, std::uint32_t(at.index * kFan + child)});
        std::push_heap(queue_.begin(), queue_.end());
      }
    }
  }

 private:
  static constexpr std::size_t kFan = 8;
  // A box is stored as x0, y0, -x1, -y1. It meets another one if none of these exceeds x1, y1, -x0, -y0 of
  // that.
  using Numbers = std::array<std::int32_t, 4>;
  static constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
  static constexpr Numbers kNowhere = {kFar, kFar, kFar, kFar};
  using Lanes = Lanes4;
  struct Node {
    Lanes lanes[4][2];  // [number][half of the children]
  };
  struct Query {
    Lanes most[4];
    explicit Query(const Box& b) {
      const Numbers m = {b.x1, b.y1, -b.x0, -b.y0};
      for (std::size_t k = 0; k < 4; ++k) most[k] = Lanes{m[k], m[k], m[k], m[k]};
    }
    Query(const Node& node, std::size_t child) {
      const std::size_t half = child / 4, lane = child % 4;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::int32_t bound = -node.lanes[(k + 2) % 4][half][lane];
        most[k] = Lanes{bound, bound, bound, bound};
      }
    }
  };

  static void put(std::vector<Node>& level, std::size_t i, const Numbers& box) {
    for (std::size_t k = 0; k < 4; ++k) level[i / kFan].lanes[k][i % kFan / 4][i % 4] = box[k];
  }
  static Numbers least(const Node& node) {
    Numbers box;
    for (std::size_t k = 0; k < 4; ++k) {
      const Lanes a = node.lanes[k][0], b = node.lanes[k][1], four = a < b ? a : b;
      const Lanes turned = __builtin_shufflevector(four, four, 2, 3, 0, 1),
                  two = four < turned ? four : turned;
      box[k] = std::min(two[0], two[1]);
    }
    return box;
  }
  static unsigned meeting(const Node& node, const Query& query) {
    const auto above = [&](std::size_t half) {
      Lanes any = node.lanes[0][half] > query.most[0];
      for (std::size_t k = 1; k < 4; ++k) any |= node.lanes[k][half] > query.most[k];
      return any;
    };
    return ~(signs(above(0)) | signs(above(1)) << 4) & 0xffu;
  }

  template <class F>
  bool down(std::size_t level, std::size_t node, const Query& query, F& f) const {
    for (unsigned met = meeting(levels_[level][node], query); met; met &= met - 1) {
      const std::size_t i = node * kFan + std::size_t(std::countr_zero(met));
      if (level ? down(level - 1, i, query, f) : f(i)) return true;
    }
    return false;
  }

  // Pairs of leaves below one node.
  template <class F>
  void pairs_in(std::size_t level, std::size_t node, F& f) const {
    const Node& here = levels_[level][node];
    const std::size_t first = node * kFan, count = std::min(kFan, size_of(level) - first);
    for (std::size_t i = 0; i < count; ++i) {
      if (level > 0) pairs_in(level - 1, first + i, f);
      for (unsigned met = meeting(here, Query(here, i)) >> 1 >> i; met; met &= met - 1)
        pairs_across(level, first + i, first + i + 1 + std::size_t(std::countr_zero(met)), f);
    }
  }
  // Pairs of leaves of which one lies below entry i and one below entry j of a level.
  template <class F>
  void pairs_across(std::size_t level, std::size_t i, std::size_t j, F& f) const {
    if (level == 0) {
      f(i, j);
      return;
    }
    const Node &one = levels_[level - 1][i], &other = levels_[level - 1][j];
    const unsigned near = meeting(other, Query(levels_[level][i / kFan], i % kFan));
    for (unsigned left = meeting(one, Query(levels_[level][j / kFan], j % kFan)); left; left &= left - 1) {
      const auto a = std::size_t(std::countr_zero(left));
      for (unsigned met = near & meeting(other, Query(one, a)); met; met &= met - 1)
        pairs_across(level - 1, i * kFan + a, j * kFan + std::size_t(std::countr_zero(met)), f);
    }
  }
  std::size_t size_of(std::size_t level) const { return level > 0 ? levels_[level - 1].size() : leaves_; }

  // From a level above the lowest.
  template <class F>
  void down_to_eights(std::size_t level, std::size_t node, const Query& query, F& f) const {
    for (unsigned rest = meeting(levels_[level][node], query); rest; rest &= rest - 1) {
      const std::size_t child = node * kFan + std::size_t(std::countr_zero(rest));
      if (level > 1)
        down_to_eights(level - 1, child, query, f);
      else if (const unsigned met = meeting(levels_[0][child], query))
        f(child * kFan, met);
    }
  }

  // The square of the distance from a point to the box of a child.
  static double square_distance(const Node& node, std::size_t child, double x, double y) {
    const auto number = [&](std::size_t k) { return double(node.lanes[k][child / 4][child % 4]); };
    const double dx = std::max(std::max(number(0) - x, x + number(2)), 0.0),
                 dy = std::max(std::max(number(1) - y, y + number(3)), 0.0);
    return dx * dx + dy * dy;
  }
  struct Disc {
    double x, y, radius;
    Query box;
    bool meets(const Node& node, std::size_t child) const {
      return square_distance(node, child, x, y) < radius * radius;
    }
  };
  template <class F>
  bool down_about(const Disc& disc, std::size_t level, std::size_t node, F& f) const {
    const Node& here = levels_[level][node];
    for (unsigned met = meeting(here, disc.box); met; met &= met - 1) {
      const std::size_t child = std::size_t(std::countr_zero(met)), i = node * kFan + child;
      if (disc.meets(here, child) && (level ? down_about(disc, level - 1, i, f) : f(i))) return true;
    }
    return false;
  }

  std::vector<std::vector<Node>> levels_ = std::vector<std::vector<Node>>(1);
  std::size_t leaves_ = 0, depth_ = 1;
  struct Place {  // an entry of a level, from 1 on; a leaf: 0
    double square;
    std::uint32_t level, index;
    bool operator<(const Place& other) const { return square > other.square; }  // nearest first in a heap
  };
  std::vector<Place> queue_;
};

inline BoxOf<std::int32_t> box_of(const Edge& e) {
  return {std::min(e.a.x, e.b.x), std::min(e.a.y, e.b.y), std::max(e.a.x, e.b.x), std::max(e.a.y, e.b.y)};
}
/// Returns the tree of the edges' boxes.
inline StaticRTree tree_of(std::span<const Edge> edges) {
  StaticRTree tree;
  tree.resize(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) tree.set(i, box_of(edges[i]));
  tree.build();
  return tree;
}

}  // namespace firn::geometry
