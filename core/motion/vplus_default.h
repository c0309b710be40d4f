// plan_default() computes the trajectory of the controller's own point following [Barnett 2012, 4.4,
// "default" in Figs. 4-12 to 4-14]: V+ moves from point to point and begins the next move while the last one
// slows down. Two consequences that the thesis reports: corners are rounded off, and where points are close
// together the speed follows their spacing.
//
// Model (a FIT: V+'s generator is not published): straight moves of duration T_i = max(L_i / v, t_b),
// velocities blended at constant acceleration over t_b around each point. A right corner is cut over v t_b /
// 2 before and after, as by a round of that radius; on short moves the speed is L_i / t_b. With t_b = 0.16 s
// and 125 mm/s the radius is the 10 mm of Fig. 4-13, and with points every 3.5 mm on the rounds the time is
// that of MTTS, as 4.4 sets it up.
#pragma once

#include <vector>

#include "core/motion/kinematics/path_input.h"

namespace firn::motion {

struct DefaultOptions {
  double blend_s = 0.16;            ///< t_b: the "acceleration" that V+ takes in percent
  double support_spacing_mm = 3.5;  ///< of supporting points on bends; 0 = take the points as they are
  double tick_s = 0.016;
};

/// The supporting points that V+ is given: ends and corners, ends of bends, and points on bends at the
/// spacing. Returns indices of path.points.
std::vector<std::size_t> supporting_points(const CleanPath& path, double spacing_mm);

/// All joints at the tick, no certificate; the duration is rounded up to whole ticks by slowing down.
/// Throws MotionError as plan_thesis does.
Trajectory plan_default(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                        const DefaultOptions& options = {});

/// The blend time with which the default technique takes as long as `duration_s` (4.4: "adjusted until the
/// time of travel is approximately the same"). Throws MotionError (kNoSolution) if no blend time is that
/// fast.
double blend_for_duration(const PathInput& input, const MotionLimits& limits, const DefaultOptions& options,
                          double duration_s);

}  // namespace firn::motion
