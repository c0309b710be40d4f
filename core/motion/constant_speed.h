// plan_constant() computes the baseline before MTTS [Barnett 2012, 4.2, 4.4]: boundary paths at one low
// speed, straight fill at a higher one with a stop between lines.
#pragma once

#include "core/motion/kinematics/path_input.h"

namespace firn::motion {

struct ConstantOptions {
  double boundary_mm_s = 25.0;                  ///< also hooks and measurement paths
  double fill_mm_s = 100.0;                     ///< 4.2; 125 in the comparison of 4.4
  double ramp_mm_s2 = 500.0;                    ///< from rest and to rest at the ends and at the stops
  double split_angle_rad = 0.5235987755982988;  ///< fill: sharper corners are stops; boundaries go through
  double tick_s = 0.016;
};

/// Points of a straight fill between which it stops: its ends and its corners above the split angle. Fill
/// that bends between its corners is followed like a boundary: only its two ends, and at the boundaries'
/// speed.
std::vector<std::size_t> fill_stops(const std::vector<Point2>& points, PathKind kind, double split_angle_rad);

/// Speed along one piece: speed limits per interval, constant acceleration at rises and falls, rest at both
/// ends.
class RampedSpeed {
 public:
  /// @p s_mm n increasing distances from 0, @p speed_limit_mm_s n - 1 speeds > 0, @p ramp_mm_s2 > 0
  RampedSpeed(const std::vector<double>& s_mm, const std::vector<double>& speed_limit_mm_s,
              double ramp_mm_s2);
  double duration_s() const { return end_s_; }
  double distance_at(double t_s) const;  ///< clamped to the ends

 private:
  struct Phase {
    double t_s, s_mm, speed_mm_s, acceleration_mm_s2;
  };
  void add(double duration_s, double speed_mm_s, double acceleration_mm_s2);
  std::vector<Phase> phases_;
  double end_s_ = 0.0, end_mm_ = 0.0;
};

/// All joints at the tick, no certificate; each piece between stops is stretched to whole ticks. Limits other
/// than the total speed are ignored: this is the method that MTTS replaces. Throws MotionError as plan_thesis
/// does.
Trajectory plan_constant(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                         const ConstantOptions& options = {});

}  // namespace firn::motion
