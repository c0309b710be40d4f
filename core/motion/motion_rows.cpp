#include "core/motion/motion_rows.h"

#include <algorithm>

namespace firn::motion {

RowGroups row_groups(const MotionLimits& limits, int joints) {
  RowGroups groups;
  groups.group[0] = {0, 2, limits.position};
  for (int j = 0; j < joints; ++j) groups.group[groups.count++] = {2 + j, 1, limits.joint[std::size_t(j)]};
  return groups;
}

std::optional<Fault> compute_rows(const Curve& curve, const Arm& arm, const Placement& place, int joints,
                                  MotionRows& rows) {
  const std::size_t cells = curve.cells(), samples = 2 * cells;
  rows.rows = 2 + joints;
  Jets& task = rows.task;
  task.resize(kTaskAxes, samples);
  for (int axis = 0; axis < 2; ++axis) {
    const double* f = axis == 0 ? curve.x.data() : curve.y.data();
    const double* m = axis == 0 ? curve.xx.data() : curve.yy.data();
    const double shift = axis == 0 ? place.flange_x_mm : place.flange_y_mm;
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
      rows.of[axis][order - 1].assign(task.of(axis, order), task.of(axis, order) + samples);
  }
  for (int order = 0; order < 4; ++order) {
    std::fill_n(task.of(kZ, order), samples, order == 0 ? place.z_mm + place.flange_z_mm : 0.0);
    std::fill_n(task.of(kYaw, order), samples, order == 0 ? place.yaw_rad : 0.0);
  }
  rows.joints.resize(std::max(joints, 1), samples);
  if (auto fault = arm.inverse_derivatives(task, place.posture, rows.joints)) {
    fault->index /= 2;
    return fault;
  }
  for (int j = 0; j < joints; ++j)
    for (int order = 1; order < 4; ++order)
      rows.of[2 + j][order - 1].assign(rows.joints.of(j, order), rows.joints.of(j, order) + samples);
  return std::nullopt;
}

}  // namespace firn::motion
