// bound_motion() computes upper bounds, true at every instant, of all limited quantities of a motion.
//
// Between two instants t apart, any f satisfies |f| <= max(|f_left|, |f_right|) + t^2 / 8 max |f''|: the
// chord plus the largest distance from it. f is the rate, the acceleration or the jerk of a row; the
// derivatives of orders 4 and 5 that this needs are bounded by the chain rule, of the tool from its cubics
// and quintics, of the joints by Arm::bound_higher. A piece of the motion is bounded as a whole with all its
// samples first, then between neighbours among them; intervals whose bound is not sharp are divided.
#pragma once

#include <optional>
#include <vector>

#include "core/motion/time_optimal/motion_samples.h"

namespace firn::motion {

/// Motion whose bounds are wanted.
struct BoundedMotion {
  const Curve& curve;
  const TimedMotion& motion;
  const Arm& arm;
  const Placement& placement;
  const RowGroups& groups;
  int joints = 0;
};

/// A motion at instants (sample_motion).
struct MotionSamples {
  StateBatch batch;
  Jets tool, joint, flange;
};

/// Buffers kept between paths.
struct BoundWork {
  struct Interval {
    std::size_t piece = 0, cell = 0;
    double from = 0.0, to = 0.0;  ///< instants
    std::size_t sample = 0;       ///< of `from`; the last of the next `steps` ones is that of `to`
    std::size_t steps = 1;        ///< equal parts between samples
  };
  MotionSamples samples;  ///< input: as check_states places them, the same number in every piece
  MotionSamples divided;
  std::vector<Interval> now, next;
  std::vector<Arm::JointJet> jets;
};

/// Sets `table`, the ratios at work.samples, to bounds over the whole motion.
/// A bound exceeds the largest sample by a share of time scaling of at most `sharpness` where that can be
/// reached. Fault: index = entry of the batch
std::optional<Fault> bound_motion(const BoundedMotion& motion, double sharpness, BoundWork& work,
                                  RatioTable& table);

}  // namespace firn::motion
