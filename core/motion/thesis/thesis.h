// plan_thesis() computes trajectories by MTTS of the thesis [Barnett 2012, ch. 4]: PATHSPLIT, VCON, ACON,
// JCON, AREST, JCON, Savitzky-Golay, output at a fixed tick. It obeys speed limits, mostly obeys acceleration
// limits and does not hold jerk limits (4.3).
#pragma once

#include <vector>

#include "core/motion/kinematics/path_input.h"
#include "core/motion/thesis/acon.h"
#include "core/motion/thesis/arest.h"
#include "core/motion/thesis/pathsplit.h"

namespace firn::motion {

struct ThesisOptions {
  thesis::PathSplitOptions split;
  thesis::Margins margins;
  thesis::RestOptions rest;
  double tick_s = 0.016;  ///< of the output; AREST works at rest.step_s, half of it
  bool filter = true;     ///< Savitzky-Golay on the joints
};

/// The profile of one subpath after each step, as Fig. 4-4 draws them.
struct ThesisSteps {
  thesis::Profile vcon, acon, jcon, arest, final;
};

struct ThesisResult {
  Trajectory trajectory;           ///< all joints of the arm at the tick; no certificate
  std::vector<ThesisSteps> steps;  ///< one per subpath
};

/// Throws MotionError: bad path or limits (clean, check_limits), path outside the workspace, option out of
/// range.
ThesisResult plan_thesis_steps(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                               const ThesisOptions& options = {});
Trajectory plan_thesis(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                       const ThesisOptions& options = {});

namespace thesis {

/// The time law of `timed` (its s_mm and dt_s, linear between points) at whole ticks, on the points of
/// `path`. The duration is stretched to a whole number of ticks, at least one. Joints are left empty.
Profile at_tick(const Profile& path, const Profile& timed, double tick_s);

}  // namespace thesis
}  // namespace firn::motion
