// PATHFILTER [Barnett, 3.2]: fewer points where they say nothing.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/few_corners.h"

namespace firn::slice {

/// First the points that lie closer than min_spacing to the last one kept go (the thesis's rule; 0.4 mm
/// there), then the ring is drawn with as few corners as a line within chord_tolerance of it needs
/// (few_corners.h). Lengths in units; 0 switches a rule off. A ring of which fewer than three corners would
/// stay vanishes: all of it lies within the tolerance of a line.
class PathFilter {
 public:
  PathFilter(double min_spacing, double chord_tolerance)
      : spacing_(min_spacing), tolerance_(chord_tolerance) {}
  /// Appends what is left of a ring; it begins where the ring does.
  void append(std::span<const Point> ring, Rings& to);

 private:
  void space(std::span<const Point> ring);

  double spacing_, tolerance_;
  std::vector<Point> points_;
  std::vector<Vec> line_;
  FewCorners draw_;
};

}  // namespace firn::slice
