// PathErrors compares the path that a stage followed, as position feedback at equal times, with the planned
// one.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/path/line_stations.h"

namespace firn {

/// Position and velocity at a time; the position is cubic between two knots.
struct PathKnot {
  double t_s = 0.0, x_mm = 0.0, y_mm = 0.0, vx_mm_s = 0.0, vy_mm_s = 0.0;
};

/// The planned path: position and velocity at any time, and the nearest point to a place.
class TimedPath {
 public:
  /// @pre times ascend from 0
  explicit TimedPath(std::vector<PathKnot> knots);

  double duration_s() const { return knots_.empty() ? 0.0 : knots_.back().t_s; }
  PathKnot at(double t_s) const;
  /// Distance to the nearest point that the plan passes between the two times.
  double distance_mm(const Point2& from, double begin_s, double end_s) const;
  double length_mm() const { return way_mm_.empty() ? 0.0 : way_mm_.back(); }
  /// Returns the place at which the way travelled is s_mm.
  PathKnot at_way(double s_mm) const;

 private:
  std::vector<PathKnot> knots_;
  std::vector<Point2> fine_;    ///< every kFine_s
  std::vector<double> way_mm_;  ///< travelled up to each of them
};

/// Errors over all samples; NaN: not known.
struct PathErrors {
  std::size_t samples = 0;
  double contour_max_mm = std::numeric_limits<double>::quiet_NaN();  ///< distance from the planned path
  double contour_rms_mm = std::numeric_limits<double>::quiet_NaN();
  double following_max_mm = std::numeric_limits<double>::quiet_NaN();  ///< from the place of the same time
  double lag_max_s = std::numeric_limits<double>::quiet_NaN();         ///< behind the plan
  double switch_max_mm = std::numeric_limits<double>::quiet_NaN();     ///< along the path
  /// Largest distance from the place planned for the time less the median lag, which is the servo's and the
  /// recording's own: an axis that stalls or drags.
  double stall_max_mm = std::numeric_limits<double>::quiet_NaN();
  Point2 worst;           ///< where contour_max_mm was found
  double worst_s = 0.0;   ///< when
  double stall_s = 0.0;   ///< the same of stall_max_mm
  int worst_switch = -1;  ///< the switch of switch_max_mm; -1: none
};

/// Compares samples, taken `period_s` apart from the beginning on, with the plan. A switch acts where the way
/// travelled, by the position feedback, is that of `switch_mm`.
PathErrors path_errors(const TimedPath& plan, double period_s, std::span<const Point2> followed,
                       std::span<const double> switch_mm);

/// Distance of each sample from the part of the plan within a second before and 20 ms after its time [mm]. A
/// stage that is farther behind or ahead is off its path.
std::vector<double> contour_errors_mm(const TimedPath& plan, double period_s,
                                      std::span<const Point2> followed);

/// Root mean square of the distance between the stations' middles and the followed path, across the line;
/// NaN where no station was passed.
double station_offset_rms_mm(std::span<const Point2> followed, std::span<const LineStation> stations);

}  // namespace firn
