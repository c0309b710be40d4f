// MinimumLinkSimplifier computes a ring with few corners within a tolerance of another one.
#pragma once

#include <span>

#include "core/geometry/region.h"
#include "core/geometry/tolerance_tube.h"

namespace firn::geometry {

class RingWriter;

/// Polyline simplification by minimum-link paths: the ring and the polyline lie within `tolerance` units of
/// each other. The ring is a path through the tolerance tube of the polyline (tolerance_tube.h) with as few
/// corners as possible, with three exceptions: it starts at the first vertex, the cross-sections stand only
/// roughly perpendicular, and straight edges end where the polyline bends. It has at most 3 % more corners
/// than the optimum by brute force. The method takes four times as long as simplify_ring() and leaves up to a
/// third fewer corners where the polyline is rough, which pays for outlines that are read many times. Keeps
/// its working memory.
class MinimumLinkSimplifier {
 public:
  /// Appends the ring.
  /// @param fixed vertices besides the first one that remain corners, ascending
  /// @return false if the ring vanishes because fewer than three corners would remain
  bool operator()(std::span<const Vec> line, double tolerance, Rings& rings,
                  std::span<const std::size_t> fixed = {});

 private:
  void draw(std::span<const Vec> line, Vec behind, ToleranceTube::Width width, RingWriter& out);
  ToleranceTube tube_;
};

}  // namespace firn::geometry
