// MotionRows holds the derivatives of all limited quantities at both ends of every cell: the constraints of
// the speed profile.
//
// Rows: 0, 1 = x, y of the tool; 2, 3, ... = the limited joints; last, where the tool turns, its yaw. With b
// = (ds/dt)^2, b' = db/ds:
//   rate = q' sqrt(b),   acceleration = q'' b + q' b' / 2,   jerk = sqrt(b) (q''' b + 3/2 q'' b' + q' b'' /
//   2).
#pragma once

#include <optional>
#include <vector>

#include "core/motion/curve/path_curve.h"
#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/limits.h"
#include "core/motion/kinematics/tool.h"

namespace firn::motion {

inline constexpr int kMaxRows = 3 + kMaxJoints, kMaxGroups = 2 + kMaxJoints;

struct MotionRows {
  int rows = 2;
  /// of[r][order - 1]: derivatives at the 2 * cells samples (2 i = left end of cell i, 2 i + 1 = its right
  /// end).
  std::vector<double> of[kMaxRows][3];
  Jets task, flange, joints;  ///< scratch
};

/// Quantity that a group limits.
enum class Quantity { kTotal, kJoint, kOrientation };

/// Limits of one row group: rows [first, first + count) form one Euclidean norm.
struct RowGroup {
  int first = 0, count = 1;
  RateLimits limit;
  Quantity of = Quantity::kJoint;
  int joint = -1;
};

/// Groups: the tool's total motion, then each limited joint, then the orientation where it is limited and
/// turns.
struct RowGroups {
  RowGroup group[kMaxGroups];
  int count = 1;
};
RowGroups row_groups(const MotionLimits& limits, int joints, bool turning);

/// A pose besides x and y, and the offset from the tool to the flange where the yaw does not change along the
/// path.
struct Placement {
  double z_mm = 0.0, yaw_rad = 0.0;
  double flange_x_mm = 0.0, flange_y_mm = 0.0, flange_z_mm = 0.0;
  bool turning = false;  ///< the curve has the yaw; then the offset is the tool's, turned with it
  Tool tool{};
  ArmConfiguration configuration;
};

/// Flange poses of a turning tool's.
const Jets& flange_of(const Placement& placement, const Jets& tool, Jets& flange);

/// Fault (index = cell) where the arm cannot follow.
std::optional<Fault> compute_rows(const Curve& curve, const Arm& arm, const Placement& placement, int joints,
                                  MotionRows& rows);

}  // namespace firn::motion
