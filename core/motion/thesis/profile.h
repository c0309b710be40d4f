// Profile holds a subpath while its durations are shaped: fixed points, adjustable point-to-point durations
// [Barnett 2012, 4.1.2].
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/kinematics/path_input.h"

namespace firn::motion::thesis {

/// n points. The steps VCON, ACON and JCON leave the points alone and only raise entries of dt.
struct Profile {
  std::vector<Point2> points;
  std::vector<double> yaw_rad;  ///< n; empty where the tool does not turn
  std::vector<double> s_mm;     ///< n, travelled distance, strictly increasing
  std::vector<std::vector<double>>
      joints;  ///< [joint][n]: the joints that have limits; then the yaw, which is shaped alike
  std::vector<double> speed_limit_mm_s;  ///< n - 1, speed limit of each interval
  std::vector<double> dt_s;              ///< n - 1, point-to-point durations

  std::size_t size() const { return points.size(); }
  double duration_s() const;
};

/// Position of the subpath's polyline at distance s (linear interpolation, ends clamped).
Point2 point_at(const Profile& profile, double s_mm);

/// Appends that position, and the yaw there, to the points of `out`; s_mm, durations and speed limits are the
/// caller's.
void append_at(const Profile& profile, double s_mm, Profile& out);

/// Radius of the circle through each point and its two neighbours [mm]; infinite on straights and at the
/// ends.
std::vector<double> radii(const std::vector<Point2>& points);

/// First, second and third rate in time of one coordinate or of the distance, from its values at n points:
/// rate on the n - 1 intervals, acceleration at points 1..n-2, jerk on intervals 1..n-3; entries outside
/// repeat their neighbour. Needs n >= 4.
struct Rates {
  std::vector<double> rate;          ///< n - 1
  std::vector<double> acceleration;  ///< n
  std::vector<double> jerk;          ///< n - 1
};
Rates rates(const std::vector<double>& values, const std::vector<double>& dt_s);

/// Euclidean norm over x and y of acceleration (n) and jerk (n - 1): the total ones, (4.1)'s dagger.
struct TotalRates {
  std::vector<double> acceleration;
  std::vector<double> jerk;
};
TotalRates total_rates(const Profile& profile);

}  // namespace firn::motion::thesis
