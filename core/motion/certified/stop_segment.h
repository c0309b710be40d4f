// StopSegment holds one planned motion between two stops.
#pragma once

#include <cstdint>

#include "core/motion/certified/constants.h"
#include "core/motion/curve/path_curve.h"
#include "core/motion/time_optimal/jerk_profile.h"
#include "core/motion/time_optimal/motion_samples.h"
#include "core/motion/time_optimal/timed_motion.h"

namespace firn::motion {

struct StopSegment {
  Curve curve;
  TimedMotion motion;
  RatioTable ratios;                ///< of `motion`, not scaled
  double factor = 1.0;              ///< the motion runs at time / factor
  double bound_s = 0.0;             ///< lower bound of its duration
  TimeGradient gradient;            ///< filled where the curve may be improved
  std::uint64_t sampled = 0;        ///< SpeedPlanner's number of the samples of `motion`
  bool proved = false;              ///< the ratios are bounds at every instant
  bool closed_form = false;         ///< `motion` is the minimum-time motion within the tool's limits
  double deviation_mm = 0.0;        ///< bound of the Frechet distance from the points (curve/frechet.h)
  double points_off_mm = 0.0;       ///< farthest_point_mm(), where points are held
  std::size_t first = 0, last = 0;  ///< input points where it starts and ends

  /// Unlimited, as deviation_mm then is, where no motion along this curve was found.
  double duration_s() const { return factor * motion.duration_s(); }
};

/// Makes the duration unlimited: no motion along this curve is wanted.
inline void give_up(StopSegment& segment) {
  segment.motion.t.assign({0.0, kUnlimited});
  segment.factor = 1.0;
}

/// Returns true unless the solver gave the speed profile up, as it does beside a cusp: its motion is then
/// slowed down by far.
inline bool solved(const StopSegment& segment) { return segment.factor < kSolvedFactor; }

}  // namespace firn::motion
