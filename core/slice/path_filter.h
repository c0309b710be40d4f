// PATHFILTER [Barnett, 3.2]: fewer points where they say nothing.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/slice/region.h"

namespace firn::slice {

/// First the points that lie closer than min_spacing to the last one kept go (the thesis's rule; 0.4 mm there), then those
/// that Douglas and Peucker's method [1973] finds within chord_tolerance of the chord that replaces them, the ring being
/// cut at its first point and at the point farthest from it. Lengths in units; 0 switches a rule off. A ring of which
/// fewer than three points would stay vanishes: all of it lies within the tolerance of a line.
class PathFilter {
 public:
  PathFilter(double min_spacing, double chord_tolerance) : spacing_(min_spacing), tolerance_(chord_tolerance) {}
  /// Appends what is left of a ring that begins at its smallest point; it still does.
  void append(std::span<const Point> ring, Rings& to);

 private:
  void space(std::span<const Point> ring);
  void simplify();

  double spacing_, tolerance_;
  std::vector<Point> points_;
  std::vector<double> x_, y_;
  std::vector<std::uint8_t> keep_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack_;
};

}  // namespace firn::slice
