// RingWriter appends a ring to others, rounded to the grid and without repeated points.
#pragma once

#include <span>

#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::geometry {

class RingWriter {
 public:
  RingWriter(Rings& rings, std::size_t maximum) : rings_(rings), begin_(rings.points.size()) {
    rings.points.resize(begin_ + maximum);
    first_ = end_ = rings.points.data() + begin_;
  }
  void add(Vec v) {
    const Point p = to_point(v);
    if (end_ == first_ || end_[-1] != p) *end_++ = p;
  }
  void clear() { end_ = first_; }
  ~RingWriter() {
    rings_.points.resize(begin_ + size());
    if (size() > 0) rings_.ends.push_back(std::uint32_t(rings_.points.size()));
  }
  std::size_t size() const { return std::size_t(end_ - first_); }

  std::span<const Point> ring() const { return {first_, end_}; }

  /// Closes the ring; a ring without area is removed. @return twice its area
  double close() {
    while (size() > 1 && end_[-1] == *first_) --end_;
    double area = 0;
    for (const Point* p = first_ + 1; p + 1 < end_; ++p)
      area += cross(to_vec(p[0]) - to_vec(*first_), to_vec(p[1]) - to_vec(*first_));
    if (area == 0) end_ = first_;
    return area;
  }

 private:
  Rings& rings_;
  std::size_t begin_;
  Point *first_, *end_;
};

}  // namespace firn::geometry
