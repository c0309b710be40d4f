// PathFilter computes contours with fewer points: PATHFILTER [Barnett, 3.2].
#pragma once

#include <span>
#include <vector>

#include "core/geometry/minimum_link.h"

namespace firn::slice {

/// First, points closer than min_spacing to the last one kept are removed (the rule of the thesis; 0.4 mm
/// there). Then the ring is drawn with as few corners as a polyline within chord_tolerance of it needs
/// (minimum_link.h). Lengths in units; 0 disables a rule. A ring of which fewer than three corners would
/// remain vanishes: it lies within the tolerance of a line.
class PathFilter {
 public:
  PathFilter(double min_spacing, double chord_tolerance)
      : spacing_(min_spacing), tolerance_(chord_tolerance) {}
  /// Appends the filtered ring, which begins at the same point.
  void append(std::span<const geometry::Point> ring, geometry::Rings& to);

 private:
  void space(std::span<const geometry::Point> ring);

  double spacing_, tolerance_;
  std::vector<geometry::Point> points_;
  std::vector<geometry::Vec> line_;
  geometry::MinimumLinkSimplifier draw_;
};

}  // namespace firn::slice
