// All pairs of boxes that overlap, among boxes whose neighbours in the list lie near each other (pieces of outlines).
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

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

/// A tree of boxes by position in the list: eight children to a box. Building and asking are linear in practice.
template <class T>
class BoxTree {
 public:
  using Box = BoxOf<T>;

  std::vector<Box>& leaves() { return levels_[0]; }  ///< fill, then build()

  void build() {
    depth_ = 1;
    while (levels_[depth_ - 1].size() > kFan) {
      if (depth_ == levels_.size()) levels_.emplace_back();
      const std::vector<Box>& below = levels_[depth_ - 1];
      std::vector<Box>& here = levels_[depth_++];
      here.assign((below.size() + kFan - 1) / kFan, Box{});
      for (std::size_t i = 0; i < below.size(); ++i) here[i / kFan].add(below[i]);
    }
  }

  /// f(i, j) with i < j for all leaves whose boxes meet.
  template <class F>
  void pairs(F&& f) const {
    self(depth_ - 1, 0, levels_[depth_ - 1].size(), f);
  }

  /// f(i) for all leaves that meet a box.
  template <class F>
  void touching(const Box& box, F&& f) const {
    down(depth_ - 1, 0, levels_[depth_ - 1].size(), box, f);
  }

 private:
  static constexpr std::size_t kFan = 8;

  std::size_t end_of(std::size_t level, std::size_t parent) const {
    return std::min(levels_[level].size(), (parent + 1) * kFan);
  }

  template <class F>
  void self(std::size_t level, std::size_t begin, std::size_t end, F& f) const {
    const Box* boxes = levels_[level].data();
    for (std::size_t i = begin; i < end; ++i) {
      if (level) self(level - 1, i * kFan, end_of(level - 1, i), f);
      for (std::size_t j = i + 1; j < end; ++j)
        if (boxes[i].meets(boxes[j])) cross(level, i, j, f);
    }
  }
  template <class F>
  void cross(std::size_t level, std::size_t i, std::size_t j, F& f) const {
    if (!level) {
      f(i, j);
      return;
    }
    const Box* below = levels_[level - 1].data();
    const Box& other = levels_[level][j];
    for (std::size_t a = i * kFan, a_end = end_of(level - 1, i); a < a_end; ++a) {
      if (!below[a].meets(other)) continue;
      for (std::size_t b = j * kFan, b_end = end_of(level - 1, j); b < b_end; ++b)
        if (below[a].meets(below[b])) cross(level - 1, a, b, f);
    }
  }
  template <class F>
  void down(std::size_t level, std::size_t begin, std::size_t end, const Box& box, F& f) const {
    for (std::size_t i = begin; i < end; ++i) {
      if (!levels_[level][i].meets(box)) continue;
      if (level) down(level - 1, i * kFan, end_of(level - 1, i), box, f);
      else f(i);
    }
  }

  std::vector<std::vector<Box>> levels_ = std::vector<std::vector<Box>>(1);
  std::size_t depth_ = 1;
};

}  // namespace firn::slice
