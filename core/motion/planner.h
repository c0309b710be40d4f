// plan() computes a trajectory with its certificate from a path, by any of the methods.
//
// Every method's trajectory passes the same checker (core/motion/certified/checker.h), so that the
// certificates compare. Methods `certified` and `optimal` never exceed a limit; `thesis`, `constant` and
// `default` may, and their certificates say where and by how much.
#pragma once

#include <memory>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/limits.h"
#include "core/motion/kinematics/path_input.h"
#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// Memory that one planner thread keeps between paths; its size is bounded by the longest path.
class PlanWorkspace {
 public:
  PlanWorkspace();
  ~PlanWorkspace();
  PlanWorkspace(PlanWorkspace&&) noexcept;
  PlanWorkspace& operator=(PlanWorkspace&&) noexcept;
  struct State;
  State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

/// Never throws MotionError: bad input (NaN, fewer than two distinct points, out of reach, a limit that is
/// not positive, an option out of its range) comes back as `fault`. @p work may serve any paths one after
/// another.
PlanResult plan(const PathInput& path, const Arm& arm, const MotionLimits& limits, const PlanOptions& options,
                PlanWorkspace& work);
PlanResult plan(const PathInput& path, const Arm& arm, const MotionLimits& limits,
                const PlanOptions& options = {});

}  // namespace firn::motion
