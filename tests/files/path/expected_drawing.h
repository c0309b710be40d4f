// ExpectedDrawing holds the curves of a generated drawing, computed from the mathematical curves alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "files/path/path_file.h"

namespace firn::test {

/// x' = xx x + xy y + x0, y' = yx x + yy y + y0.
struct Affine {
  double xx = 1.0, xy = 0.0, x0 = 0.0, yx = 0.0, yy = 1.0, y0 = 0.0;
  Point2 operator()(Point2 p) const {
    return {xx * p.x_mm + xy * p.y_mm + x0, yx * p.x_mm + yy * p.y_mm + y0};
  }
};

/// First `inner`, then `outer`.
inline Affine after(const Affine& outer, const Affine& inner) {
  const Point2 origin = outer({inner.x0, inner.y0}), x = outer({inner.xx + inner.x0, inner.yx + inner.y0}),
               y = outer({inner.xy + inner.x0, inner.yy + inner.y0});
  return {x.x_mm - origin.x_mm, y.x_mm - origin.x_mm, origin.x_mm,
          x.y_mm - origin.y_mm, y.y_mm - origin.y_mm, origin.y_mm};
}

struct ExpectedDrawing {
  std::size_t count = 0;
  double length_mm = 0.0, left = 1e9, right = -1e9, below = 1e9, above = -1e9;

  void add(const std::vector<Point2>& path) {
    ++count;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (i > 0) length_mm += distance(path[i - 1], path[i]);
      left = std::min(left, path[i].x_mm);
      right = std::max(right, path[i].x_mm);
      below = std::min(below, path[i].y_mm);
      above = std::max(above, path[i].y_mm);
    }
  }
  /// The curve from parameter 0 to 1, as drawn by the map.
  void add(const Affine& map, const std::function<Point2(double)>& curve) {
    constexpr int kParts = 4000;
    std::vector<Point2> path;
    for (int i = 0; i <= kParts; ++i) path.push_back(map(curve(double(i) / kParts)));
    add(path);
  }
};

/// Names count, length and bounding box of the paths that were read where they are not as built; otherwise
/// empty.
inline std::string difference(const std::vector<InputPath>& paths, const ExpectedDrawing& built) {
  ExpectedDrawing found;
  for (const InputPath& p : paths) found.add(p.path.points);
  constexpr double kSampled = 1e-3, kEdge_mm = 5e-3;  // chords of the reader's samples
  std::ostringstream out;
  const auto compare = [&](const char* what, double read, double expected, double tolerance) {
    if (!(std::abs(read - expected) <= tolerance)) out << what << ' ' << read << ", not " << expected << "; ";
  };
  compare("count", double(found.count), double(built.count), 0.0);
  compare("length", found.length_mm, built.length_mm, 1e-3 + kSampled * built.length_mm);
  compare("left", found.left, built.left, kEdge_mm);
  compare("right", found.right, built.right, kEdge_mm);
  compare("below", found.below, built.below, kEdge_mm);
  compare("above", found.above, built.above, kEdge_mm);
  return out.str();
}

}  // namespace firn::test
