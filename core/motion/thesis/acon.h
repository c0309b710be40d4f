// acon() computes ACON [Barnett 2012, 4.1.3, 4.2.4, Fig. 4-5]: acceleration curves through points that break
// an acceleration limit or whose speed rises too suddenly. Imposed one coordinate after another; only raises
// durations.
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/thesis/profile.h"

namespace firn::motion::thesis {

/// Margins by which a limit must be exceeded before a point counts as a violation (4.2.4).
struct Margins {
  double acceleration = 0.10;
  double jerk = 0.20;
};

/// The positive root t of j t^3 / 6 + a t^2 / 2 + v t = ds (4.7). Errata: two of the three roots need not be
/// complex (j = 4000, a = 500, v = 10, ds = 0.4 has three real ones); for j > 0 and a, v >= 0 exactly one is
/// positive.
double time_over_distance(double jerk, double acceleration, double speed, double distance);

/// One coordinate as an acceleration curve sees it: steps >= 0 in its direction of motion.
struct Ladder {
  std::vector<double> step;    ///< n - 1: ds or |dq|
  std::vector<double> radius;  ///< n: of the path; infinite for joints, which have no radial part
};

struct CurveStart {
  std::size_t point = 0;
  double speed = 0.0;
  double acceleration = 0.0;  ///< >= 0, in the direction in which the curve runs
};

/// Fig. 4-5 with its errata: the entry replaced is dt_i (time from i to i + 1); after i <- i + 1 the update
/// uses dt_{i-1} and c_{i-1}; where the curve is faster than the envelope it ends ("then f <- 0"); a_t = 0
/// once the radial part alone uses up the limit. direction = +1 forward, -1 backward; `end` is the last point
/// it may reach. Where the envelope at the start is as slow as the curve, the start moves along it. Returns
/// whether an entry was raised.
bool acceleration_curve(const Ladder& ladder, CurveStart start, int direction, std::size_t end,
                        const RateLimits& limits, std::vector<double>& dt_s);

/// ACON for the total position, then for each joint in sections of one sign of its rate; repeated until
/// nothing changes, at most `rounds` times.
void acon(Profile& profile, const MotionLimits& limits, const Margins& margins, int rounds = 20);

}  // namespace firn::motion::thesis
