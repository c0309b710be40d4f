// Boxes that a box meets, among boxes whose neighbours in the list lie near each other (pieces of outlines).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/geometry/box_pairs.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// A tree as BoxTree, to be asked only: eight children to a box, whose numbers stand side by side, so that
/// all eight are compared at once. Leaves are told in ascending order. Keeps its working memory.
class BoxSearch {
 public:
  using Box = BoxOf<std::int32_t>;

  /// All leaves are to be set, then build().
  void resize(std::size_t leaves) {
    leaves_ = leaves;
    levels_[0].resize((leaves + kFan - 1) / kFan);
    for (std::size_t i = leaves; i < levels_[0].size() * kFan; ++i) put(levels_[0], i, kNowhere);
  }
  void set(std::size_t leaf, std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
    put(levels_[0], leaf, {x0, y0, -x1, -y1});
  }
  void set(std::size_t leaf, const Box& b) { set(leaf, b.x0, b.y0, b.x1, b.y1); }
  /// Leaves, as many as points: the ways from each point to the next one in its ring.
  void set_rings(const Rings& rings) {
    const std::span<const Point> p = rings.points;
    resize(p.size());
    std::size_t i = 0;
    for (; i + 4 < p.size(); i += 4) {  // as if all were one line; what joins two rings is put right below
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

  /// f(i) for all leaves that meet a box.
  template <class F>
  void touching(const Box& b, F&& f) const {
    any_touching(b, [&](std::size_t i) {
      f(i);
      return false;
    });
  }
  /// f(i, which) for leaves [i, i + 8) of which some meet a box: a bit each.
  template <class F>
  void eights_touching(const Box& b, F&& f) const {
    if (leaves_ == 0) return;
    const Query query(b);
    if (depth_ > 1)
      down_to_eights(depth_ - 1, 0, query, f);
    else if (const unsigned met = meeting(levels_[0][0], query))
      f(0, met);
  }
  /// touching() until f(i) is true. @return whether it was
  template <class F>
  bool any_touching(const Box& b, F&& f) const {
    return leaves_ > 0 && down(depth_ - 1, 0, Query(b), f);
  }
  /// The same for all leaves whose boxes have places nearer to (x, y) than `distance`.
  template <class F>
  bool any_nearer(double x, double y, double distance, F&& f) const {
    return leaves_ > 0 && down_about({x, y, distance, Query(box_about(x, y, distance))}, depth_ - 1, 0, f);
  }

 private:
  static constexpr std::size_t kFan = 8;
  // A box is x0, y0, -x1, -y1: it meets another where none of its numbers is above x1, y1, -x0, -y0 of that.
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

  struct Disc {
    double x, y, radius;
    Query box;
    bool meets(const Node& node, std::size_t child) const {
      const auto number = [&](std::size_t k) { return double(node.lanes[k][child / 4][child % 4]); };
      const double dx = std::max(std::max(number(0) - x, x + number(2)), 0.0),
                   dy = std::max(std::max(number(1) - y, y + number(3)), 0.0);
      return dx * dx + dy * dy < radius * radius;
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
};

}  // namespace firn::slice
