// Computes the emitted motion at chosen instants: tool and joints with their derivatives in time, and the
// ratios of all limited quantities to their limits.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/motion/time_optimal/motion_rows.h"
#include "core/motion/time_optimal/timed_motion.h"

namespace firn::motion {

/// Path states and where they are: cell of the curve for each (a state on a knot belongs to either side).
struct StateBatch {
  std::vector<PathState> state;
  std::vector<std::size_t> cell;
  std::vector<double> time;
  void clear() {
    state.clear();
    cell.clear();
    time.clear();
  }
  std::size_t size() const { return state.size(); }
};

/// Largest ratios so far: [group][rate, acceleration, jerk], and when.
struct RatioTable {
  double ratio[kMaxGroups][3] = {};
  double time_s[kMaxGroups][3] = {};
  double speed_limit = 0.0;  ///< of the path speed to its limit

  /// The factor by which time must be scaled so that no ratio exceeds 1; below 1 the motion may be faster.
  double time_factor() const;
  /// The ratios after scaling time by `factor`.
  void scale_time(double factor);
  void merge(const RatioTable& other, double time_shift_s);
};

/// max(rate, acceleration^(1/2), jerk^(1/3)) of three ratios.
double factor_of(const double* ratio);

/// Per-instant states -> tool and joint derivatives with respect to time; joint positions (and the check of
/// their ranges) if wanted. Fault: index = entry of the batch.
std::optional<Fault> sample_motion(const Curve& curve, const StateBatch& batch, const Arm& arm,
                                   const Placement& placement, int joints, bool positions, Jets& tool,
                                   Jets& joint, Jets& flange);

/// Adds a batch's ratios to `table`. @pre tool, joint as sample_motion leaves them
void add_ratios(const Curve& curve, const StateBatch& batch, const Jets& tool, const Jets& joint,
                const RowGroups& groups, RatioTable& table);

/// For each cell of the curve the factor by which time must be scaled for the states in it.
void cell_factors(const Curve& curve, const StateBatch& batch, const Jets& tool, const Jets& joint,
                  const RowGroups& groups, std::vector<double>& factor);

/// States at both ends (from inside) and at `inner` equally spaced instants inside every piece of the motion.
void check_states(const Curve& curve, const TimedMotion& motion, int inner, StateBatch& batch);

}  // namespace firn::motion
