// Draws a motion along its path: a value as the path's colour, the deviation from the points'
// polygon, and how near the motion is to each limit.
#pragma once

#include <string>
#include <vector>

#include "core/motion/trajectory/plan.h"
#include "core/path/path.h"

namespace firn::report {

/// A value per sample, drawn from 0 to `top`.
struct PathColours {
  std::vector<double> value;
  double top = 1.0;
  std::string name;  ///< with unit
  int decimals = 0;  ///< of the colour bar's numbers
};

/// Draws the path in true proportion, coloured; beneath it the polygon of `points`, if any. Where s_mm falls,
/// another path begins.
std::string path_map(const std::vector<motion::TraceSample>& trace, const PathColours& colours,
                     const std::vector<Point2>& points, const std::string& title);

/// Distance along the path of each sample [mm].
std::vector<double> along_path(const std::vector<motion::TraceSample>& trace);

/// Distance of each sample from the polygon of `points` near the same share of its length [mm].
/// @pre points has at least two entries
std::vector<double> deviations(const std::vector<motion::TraceSample>& trace,
                               const std::vector<Point2>& points);

/// One limited quantity over its limit at each sample.
struct LimitActivity {
  std::string name;
  std::vector<double> share;
};
/// Draws a strip per limit over the distance along the path: cividis from 0 to 1, orange above.
std::string limit_strips(const std::vector<double>& along_mm, const std::vector<LimitActivity>& limits,
                         double width, const std::string& title);

}  // namespace firn::report
