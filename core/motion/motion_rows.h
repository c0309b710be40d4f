// Derivatives of everything that is limited, at every cell's both ends: what the speed profile is subject to.
//
// Rows: 0, 1 = x, y of the tool; 2, 3, ... = the limited joints. With b = (ds/dt)^2, b' = db/ds:
//   rate = q' sqrt(b),   acceleration = q'' b + q' b' / 2,   jerk = sqrt(b) (q''' b + 3/2 q'' b' + q' b'' /
//   2).
#pragma once

#include <optional>
#include <vector>

#include "core/motion/arm.h"
#include "core/motion/limits.h"
#include "core/motion/path_curve.h"

namespace firn::motion {

inline constexpr int kMaxRows = 2 + kMaxJoints;

struct MotionRows {
  int rows = 2;
  /// of[r][order - 1]: derivatives at the 2 * cells samples (2 i = left end of cell i, 2 i + 1 = its right
  /// end).
  std::vector<double> of[kMaxRows][3];
  Jets task, joints;  ///< scratch
};

/// Limits of one row group: rows [first, first + count) form one Euclidean norm.
struct RowGroup {
  int first = 0, count = 1;
  RateLimits limit;
};

/// Groups: the tool's total motion, then each limited joint.
struct RowGroups {
  RowGroup group[1 + kMaxJoints];
  int count = 1;
};
RowGroups row_groups(const MotionLimits& limits, int joints);

/// A pose besides x and y, and the offset from the tool to the flange (constant: yaw does not change along a
/// path).
struct Placement {
  double z_mm = 0.0, yaw_rad = 0.0;
  double flange_x_mm = 0.0, flange_y_mm = 0.0, flange_z_mm = 0.0;
  Posture posture;
};

/// Fault (index = cell) where the arm cannot follow.
std::optional<Fault> compute_rows(const Curve& curve, const Arm& arm, const Placement& placement, int joints,
                                  MotionRows& rows);

}  // namespace firn::motion
