#include "core/motion/kinematics/arm.h"

namespace firn::motion {

JointVector Arm::inverse(const TaskVector& pose, const ArmConfiguration& configuration) const {
  Jets task(kTaskAxes, 1), out(joints(), 1);
  for (int axis = 0; axis < kTaskAxes; ++axis) task.of(axis, 0)[0] = pose[std::size_t(axis)];
  if (auto fault = inverse(task, configuration, out)) throw MotionError(*fault);
  JointVector q{};
  for (int joint = 0; joint < joints(); ++joint) q[std::size_t(joint)] = out.of(joint, 0)[0];
  return q;
}

TaskVector Arm::forward(const JointVector& q) const {
  Jets in(joints(), 1), out(kTaskAxes, 1);
  for (int joint = 0; joint < joints(); ++joint) in.of(joint, 0)[0] = q[std::size_t(joint)];
  forward(in, out);
  TaskVector pose{};
  for (int axis = 0; axis < kTaskAxes; ++axis) pose[std::size_t(axis)] = out.of(axis, 0)[0];
  return pose;
}

}  // namespace firn::motion
