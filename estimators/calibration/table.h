// Estimates the table's plane and computes the turns of feet or screws that level it [Barnett 2012, 2.2].
#pragma once

#include <span>
#include <string>
#include <vector>

#include "estimators/calibration/robust_fit.h"

namespace firn::calibration {

/// A height of the table under the laser.
struct TablePoint {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;
};
/// A foot or a screw that lifts the table at its place.
struct Lifter {
  std::string name;  ///< "foot 1", "screw 5"
  double x_mm = 0.0, y_mm = 0.0;
  double pitch_mm = 1.0;  ///< lift per turn; above 0 = clockwise lifts
};
struct Turn {
  std::string name;
  double lift_mm = 0.0;  ///< above 0 = up
  double turns = 0.0;    ///< above 0 = clockwise
};
struct TableLevel {
  Estimate height_mm;         ///< of the plane at the middle
  Estimate slope_x, slope_y;  ///< mm per mm
  Estimate twist;  ///< mm per mm^2, of (x - middle)(y - middle): by four feet; 0 where not asked for
  Estimate bend_x,
      bend_y;  ///< mm per mm^2, of dx^2 and dy^2 about the middle: by screws; 0 where not asked for
  double bend_xxy = 0.0, bend_xyy = 0.0,
         bend_xxyy = 0.0;   ///< mm per mm^3, mm^4: and the rest of a surface through three by three screws
  double spread_mm = 0.0;   ///< highest less lowest point
  bool level = false;       ///< spread within the tolerance
  std::vector<Turn> turns;  ///< those of more than `min_mm`; none once level
  double left_mm = 0.0;     ///< spread that the turns should leave
  FitResult fit;
  double plane_mm(double x_mm, double y_mm) const;
  double twisted_mm(double x_mm, double y_mm) const;  ///< the same with twist and bend
  double middle_x_mm = 0.0, middle_y_mm = 0.0;  ///< the points' mean, unless asked for about another place
  std::vector<double> off_mm;                   ///< each point's, of the surface fitted
};

/// Coarse (2.2: four feet, until all lie within 0.5 mm): the feet take slope and twist out, the mean of their
/// lifts being zero; with fewer than seven points the slope alone. @throws Unidentifiable: fewer than five
/// points, points on one line
TableLevel level_by_feet(std::span<const TablePoint> points, std::span<const Lifter> feet,
                         double tolerance_mm = 0.5, double min_mm = 0.05);

/// The table alone, nothing to be turned: its height at (x, y), slopes, with seven points or more its twist;
/// with 15 its bend, a parabola along x times one along y, the lowest surface through three by three screws.
/// Near points share their unevenness (uneven.h): their scatter alone would make the intervals too narrow.
/// @param bent screws were turned. Otherwise the prior probability of a bend is 1 / 300, and value and
/// interval are the posterior mean over flat and bent. A bend makes the height twice as uncertain
/// @throws Unidentifiable: as level_by_feet
TableLevel table_about(std::span<const TablePoint> points, double x_mm, double y_mm, bool bent);

/// Fine (nine screws, within 0.2 mm): each screw removes the distance of the nearest points from their mean;
/// a screw's lift falls off linearly to its neighbours, so the lifts solve that system for the points.
/// @throws Unidentifiable: fewer points than screws
TableLevel level_by_screws(std::span<const TablePoint> points, std::span<const Lifter> screws,
                           double tolerance_mm = 0.2, double min_mm = 0.02);

}  // namespace firn::calibration
