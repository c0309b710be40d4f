#include "core/motion/time_optimal/motion_rows.h"

#include <algorithm>

namespace firn::motion {

RowGroups row_groups(const MotionLimits& limits, int joints, bool turning) {
  RowGroups groups;
  groups.group[0] = {0, 2, limits.position, Quantity::kTotal, -1};
  for (int j = 0; j < joints; ++j)
    groups.group[groups.count++] = {2 + j, 1, limits.joint[std::size_t(j)], Quantity::kJoint, j};
  const RateLimits& o = limits.orientation;
  if (turning && std::min({o.rate, o.acceleration, o.jerk}) < kUnlimited)
    groups.group[groups.count++] = {2 + joints, 1, o, Quantity::kOrientation, -1};
  return groups;
}

const Jets& flange_of(const Placement& place, const Jets& tool, Jets& flange) {
  if (!place.turning) return tool;
  flange.resize(kTaskAxes, tool.samples());
  tool_to_flange(place.tool, tool, flange);
  return flange;
}

std::optional<Fault> compute_rows(const Curve& curve, const Arm& arm, const Placement& place, int joints,
                                  MotionRows& rows) {
  const std::size_t cells = curve.cells(), samples = 2 * cells;
  rows.rows = 2 + joints + (place.turning ? 1 : 0);
  Jets& task = rows.task;
  task.resize(kTaskAxes, samples);
  for (int order = 0; order < 4; ++order) {
    std::fill_n(task.of(kZ, order), samples, order == 0 ? place.z_mm + place.flange_z_mm : 0.0);
    std::fill_n(task.of(kYaw, order), samples, order == 0 ? place.yaw_rad : 0.0);
  }
  for (const int axis : {int(kX), int(kY), int(kYaw)}) {
    if (axis == kYaw && !place.turning) continue;
    const double* f = axis == kX ? curve.x.data() : axis == kY ? curve.y.data() : curve.yaw.data();
    const double* m = axis == kX ? curve.xx.data() : axis == kY ? curve.yy.data() : curve.yaw2.data();
    const double shift = axis == kX ? place.flange_x_mm : axis == kY ? place.flange_y_mm : 0.0;
    double *p = task.of(axis, 0), *d1 = task.of(axis, 1), *d2 = task.of(axis, 2), *d3 = task.of(axis, 3);
    for (std::size_t i = 0; i < cells; ++i) {
      const double h = curve.s[i + 1] - curve.s[i], over = 1.0 / h, slope = (f[i + 1] - f[i]) * over;
      p[2 * i] = f[i] + shift;
      p[2 * i + 1] = f[i + 1] + shift;
      d1[2 * i] = slope - h * (2.0 * m[i] + m[i + 1]) / 6.0;
      d1[2 * i + 1] = slope + h * (m[i] + 2.0 * m[i + 1]) / 6.0;
      d2[2 * i] = m[i];
      d2[2 * i + 1] = m[i + 1];
      d3[2 * i] = d3[2 * i + 1] = (m[i + 1] - m[i]) * over;
    }
    for (int order = 1; order < 4; ++order)
      rows.of[axis == kYaw ? 2 + joints : axis][order - 1].assign(task.of(axis, order),
                                                                  task.of(axis, order) + samples);
  }
  rows.joints.resize(std::max(joints, 1), samples);
  if (auto fault =
          arm.inverse_derivatives(flange_of(place, task, rows.flange), place.configuration, rows.joints)) {
    if (place.turning) fault->at = {task.of(kX, 0)[fault->index], task.of(kY, 0)[fault->index]};
    fault->index /= 2;
    return fault;
  }
  for (int j = 0; j < joints; ++j)
    for (int order = 1; order < 4; ++order)
      rows.of[2 + j][order - 1].assign(rows.joints.of(j, order), rows.joints.of(j, order) + samples);
  return std::nullopt;
}

}  // namespace firn::motion
