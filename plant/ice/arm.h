// TrueArm computes the true motion of the arm: joint references of a point list, 16 ms apart and straight
// between, a second-order servo per joint, and the end effector as a mass on a flexible 0.5 m cantilever
// under the flange. The model is linear and is stepped exactly (second_order.h) on a fixed raster of 4 ms of
// the robot's clock; positions are straight between two samples. A sample is never revised: a command acts
// from the next sample on.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "plant/config/ice_config.h"
#include "plant/ice/second_order.h"
#include "plant/record/archive.h"

namespace firn::plant {

using Joints = std::array<double, 4>;  ///< rad, rad, mm, rad

/// Holds the pose of the flange with the end effector's deflection in x and y, in the part frame.
struct ArmPose {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;
  double cos_yaw = 1.0, sin_yaw = 0.0;
  double vx_mm_s = 0.0, vy_mm_s = 0.0;

  struct Point {
    double x_mm, y_mm, z_mm;
  };
  Point tool(const IceTool& t) const {
    return {x_mm + cos_yaw * t.x_mm - sin_yaw * t.y_mm, y_mm + sin_yaw * t.x_mm + cos_yaw * t.y_mm,
            z_mm + t.z_mm};
  }
};

class TrueArm {
 public:
  static constexpr double kStep_s = 0.004;  ///< of the robot's clock
  static constexpr double kSettle_s = 4.0;  ///< after a motion, until the arm counts as still

  explicit TrueArm(const IceArmParams& params);

  /// Starts at rest at these joints.
  void place(const Joints& q);
  /// Follows `points` (tick_s apart on the robot's clock, the first one at world time start_s). A motion
  /// before it ends at its commanded place.
  void follow(std::vector<Joints> points, double tick_s, double start_s);
  /// Adds points to the motion under way. @pre commanded()
  void extend(const std::vector<Joints>& points) {
    points_.insert(points_.end(), points.begin(), points.end());
  }
  /// Comes to rest along the path, from the next sample on: the rate of the path's time falls to zero within
  /// `within_s`.
  void brake(double within_s);

  bool commanded() const { return !points_.empty(); }
  double end_s() const;  ///< world time at which the reference comes to rest; in the past at rest
  Joints reference() const { return reference_; }  ///< at the newest sample
  Joints encoders() const;                         ///< at the newest sample, in whole counts
  const ArmPose& newest() const { return pose_[1]; }
  double newest_s() const { return start_s_ + double(sample_) * step_s_; }
  bool still() const { return still_; }

  /// Computes samples up to `t_s` (world time) and reports each to `seen` (may be null).
  using Seen = std::function<void(double t_s, const ArmPose& pose)>;
  void run_until(double t_s, const Seen& seen);
  /// Computes one more sample where `t_s` needs it. @pre run_until(t_s) was called, or still; t_s not before
  /// the sample before the newest.
  ArmPose at(double t_s, const Seen& seen);
  void io(Archive& a);

 private:
  void take_sample();
  Joints reference_at(double path_s) const;
  void show();
  double left_s() const;  ///< of the path, at the present rate of its time

  IceArmParams params_;
  double step_s_;  ///< in world time
  SecondOrder servo_, flex_;
  std::array<SecondOrder::State, 4> joint_{};
  std::array<SecondOrder::State, 2> tip_{};
  Joints reference_{};
  std::array<double, 2> flange_{};
  std::array<ArmPose, 2> pose_{};  ///< before and newest
  std::vector<Joints> points_;
  double tick_s_ = 0.016, path_s_ = 0.0, rate_ = 1.0, brake_per_s_ = 0.0;
  double start_s_ = 0.0, settle_s_ = 0.0;
  std::int64_t sample_ = 0;
  bool still_ = true;
};

}  // namespace firn::plant
