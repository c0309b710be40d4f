// All pairs of boxes that overlap, among boxes whose neighbours in the list lie near each other (pieces of
// outlines).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/geometry/lanes.h"

namespace firn::slice {

template <class T>
struct BoxOf {
  T x0 = std::numeric_limits<T>::max(), y0 = std::numeric_limits<T>::max();
  T x1 = std::numeric_limits<T>::lowest(), y1 = std::numeric_limits<T>::lowest();

  void add(T x, T y) {
    x0 = std::min(x0, x), y0 = std::min(y0, y);
    x1 = std::max(x1, x), y1 = std::max(y1, y);
  }
  void add(const BoxOf& o) {
    x0 = std::min(x0, o.x0), y0 = std::min(y0, o.y0);
    x1 = std::max(x1, o.x1), y1 = std::max(y1, o.y1);
  }
  bool meets(const BoxOf& o) const { return (x0 <= o.x1) & (o.x0 <= x1) & (y0 <= o.y1) & (o.y0 <= y1); }
};

/// The square about a place, rounded outward.
inline BoxOf<std::int32_t> box_about(double x, double y, double reach) {
  return {std::int32_t(x - reach) - 1, std::int32_t(y - reach) - 1, std::int32_t(x + reach) + 1,
          std::int32_t(y + reach) + 1};
}

/// A box as x0, y0, -x1, -y1, so that four comparisons are one.
inline Lanes4 packed(const BoxOf<std::int32_t>& b) { return Lanes4{b.x0, b.y0, -b.x1, -b.y1}; }
/// What no number of a packed box is above that meets this one.
inline Lanes4 reach_of(Lanes4 packed) { return -__builtin_shufflevector(packed, packed, 2, 3, 0, 1); }
inline bool within(Lanes4 packed, Lanes4 reach) { return signs(packed > reach) == 0; }

/// A tree of boxes by position in the list: eight children to a box. Building and asking are linear in
/// practice.
class BoxTree {
 public:
  using Box = BoxOf<std::int32_t>;

  /// All leaves are to be set, then build().
  void resize(std::size_t leaves) { levels_[0].resize(leaves); }
  void set(std::size_t leaf, std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
    levels_[0][leaf].lanes = Lanes{x0, y0, -x1, -y1};
  }
  void set(std::size_t leaf, const Box& b) { set(leaf, b.x0, b.y0, b.x1, b.y1); }

  void build() {
    depth_ = 1;
    while (levels_[depth_ - 1].size() > kFan) {
      if (depth_ == levels_.size()) levels_.emplace_back();
      const std::vector<Packed>& below = levels_[depth_ - 1];
      std::vector<Packed>& here = levels_[depth_++];
      here.resize((below.size() + kFan - 1) / kFan);
      for (std::size_t i = 0; i < here.size(); ++i) {
        Lanes all = below[i * kFan].lanes;
        for (std::size_t k = i * kFan + 1, end = std::min(below.size(), (i + 1) * kFan); k < end; ++k)
          all = below[k].lanes < all ? below[k].lanes : all;
        here[i].lanes = all;
      }
    }
  }

  /// f(i, j) with i < j for all leaves whose boxes meet.
  template <class F>
  void pairs(F&& f) const {
    self(depth_ - 1, 0, levels_[depth_ - 1].size(), f);
  }

  /// f(i) for all leaves that meet a box.
  template <class F>
  void touching(const Box& b, F&& f) const {
    down(depth_ - 1, 0, levels_[depth_ - 1].size(), reach_of(packed(b)), f);
  }

 private:
  static constexpr std::size_t kFan = 8;

  using Lanes = Lanes4;
  struct Packed {
    Lanes lanes;
  };

  std::size_t end_of(std::size_t level, std::size_t parent) const {
    return std::min(levels_[level].size(), (parent + 1) * kFan);
  }

  template <class F>
  void self(std::size_t level, std::size_t begin, std::size_t end, F& f) const {
    const Packed* boxes = levels_[level].data();
    for (std::size_t i = begin; i < end; ++i) {
      if (level) self(level - 1, i * kFan, end_of(level - 1, i), f);
      const Lanes mine = reach_of(boxes[i].lanes);
      for (std::size_t j = i + 1; j < end; ++j)
        if (within(boxes[j].lanes, mine)) cross(level, i, j, f);
    }
  }
  template <class F>
  void cross(std::size_t level, std::size_t i, std::size_t j, F& f) const {
    if (!level) {
      f(i, j);
      return;
    }
    const Packed* below = levels_[level - 1].data();
    const Lanes first = reach_of(levels_[level][i].lanes), second = reach_of(levels_[level][j].lanes);
    std::size_t near[kFan], count = 0;
    for (std::size_t b = j * kFan, b_end = end_of(level - 1, j); b < b_end; ++b) {
      near[count] = b;
      count += within(below[b].lanes, first);
    }
    for (std::size_t a = i * kFan, a_end = end_of(level - 1, i); a < a_end; ++a) {
      if (!within(below[a].lanes, second)) continue;
      const Lanes mine = reach_of(below[a].lanes);
      for (std::size_t n = 0; n < count; ++n)
        if (within(below[near[n]].lanes, mine)) cross(level - 1, a, near[n], f);
    }
  }
  template <class F>
  void down(std::size_t level, std::size_t begin, std::size_t end, Lanes reach, F& f) const {
    for (std::size_t i = begin; i < end; ++i) {
      if (!within(levels_[level][i].lanes, reach)) continue;
      if (level)
        down(level - 1, i * kFan, end_of(level - 1, i), reach, f);
      else
        f(i);
    }
  }

  std::vector<std::vector<Packed>> levels_ = std::vector<std::vector<Packed>>(1);
  std::size_t depth_ = 1;
};

}  // namespace firn::slice
