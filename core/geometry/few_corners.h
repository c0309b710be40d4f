// A ring with few corners near one with many.
#pragma once

#include <span>

#include "core/geometry/corridor.h"
#include "core/geometry/region.h"

namespace firn::slice {

class RingWriter;

/// Rings near lines, rounded to the grid: each lies within `tolerance` units of the other. A ring is a path
/// through the corridor of that half width, with as few corners as there can be (corridor.h) but that it sets
/// out from the line's first place, that gates stand across the way only roughly, and that straight edges end
/// where the line bends: within 3 % of the best by brute force. Takes four times as long as thin_ring() and
/// leaves up to a third fewer corners where the line is rough: worth it for what is read many times. Keeps
/// its working memory.
class FewCorners {
 public:
  /// Appends the ring. @param stay places beside the first one that stay corners, ascending @return false if
  /// the ring vanishes: less than three corners would stay
  bool operator()(std::span<const Vec> line, double tolerance, Rings& rings,
                  std::span<const std::size_t> stay = {});

 private:
  void draw(std::span<const Vec> line, Vec behind, Corridor::Width width, RingWriter& out);
  Corridor corridor_;
};

}  // namespace firn::slice
