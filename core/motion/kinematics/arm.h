// Arm computes the kinematics of a positioning system. The planners use only `Arm`; SCARA and Cartesian stage
// are two of its kinds. All work is done in batches (one virtual call per batch). Angles rad, lengths mm,
// base frame of the arm.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/motion/kinematics/fault.h"
#include "core/motion/kinematics/jets.h"

namespace firn::motion {

struct JointRange {
  double low = 0.0;
  double high = 0.0;
};

/// One of the inverse solutions: chosen once per path and kept, so that the joints are continuous.
struct ArmConfiguration {
  int elbow = 1;      ///< SCARA: +1 = theta_2 > 0, -1 = theta_2 < 0
  int yaw_turns = 0;  ///< whole turns added to the yaw, which unwinds the wrist joint
  bool operator==(const ArmConfiguration&) const = default;
};

/// Bounds of the flange's motion over a short interval of one parameter, for Arm::bound_higher.
struct FlangeBounds {
  double x_mm = 0.0, y_mm = 0.0;     ///< a place of the interval
  double radius_mm = 0.0;            ///< no place is further from it
  std::array<double, 2> position{};  ///< largest |derivative| of (x, y), orders 4 and 5; z is constant
  std::array<double, 2> yaw{};       ///< the same of the yaw
  double width = 0.0;                ///< from sample to sample
};

class Arm {
 public:
  virtual ~Arm() = default;
  virtual int joints() const = 0;
  virtual std::string joint_name(int joint) const = 0;  ///< "J1", "x"
  virtual std::string joint_unit(int joint) const = 0;  ///< "rad" or "mm"
  virtual JointRange range(int joint) const = 0;
  virtual bool turns() const = 0;  ///< the tool's yaw can change along a path

  /// Joint positions and derivatives of poses (axes kTaskAxes: x, y, z, yaw with derivatives with respect to
  /// one parameter). Fills out.axes() joints, the first ones; out has been resized by the caller. The ranges
  /// of all joints are checked in any case. Returns the first fault along the batch (index = sample), joints
  /// there unspecified.
  virtual std::optional<Fault> inverse(const Jets& task, const ArmConfiguration& configuration,
                                       Jets& out) const = 0;

  /// Only the derivatives of inverse (orders 1 to 3), without positions and their ranges, where that is
  /// cheaper.
  virtual std::optional<Fault> inverse_derivatives(const Jets& task, const ArmConfiguration& configuration,
                                                   Jets& out) const {
    return inverse(task, configuration, out);
  }

  /// Derivatives of orders 1 to 3 at one end of an interval.
  using JointJet = std::array<JointVector, 3>;
  /// Bounds of the joints' derivatives of orders 4 and 5 over a short interval with two or more equally
  /// spaced samples, the first and last at its ends. False: the interval is too long to tell.
  virtual bool bound_higher(const FlangeBounds& flange, std::span<const JointJet> samples,
                            std::array<JointVector, 2>& bounds) const = 0;

  /// Poses of joint motions (all joints, derivatives with respect to one parameter). @pre out is kTaskAxes x
  /// samples
  virtual void forward(const Jets& joints, Jets& out) const = 0;

  /// d(x, y, z, yaw)/d(joint), and its derivative in time at joint rates `rate`. Row = task axis.
  using Jacobian = std::array<JointVector, kTaskAxes>;
  virtual Jacobian jacobian(const JointVector& q) const = 0;
  virtual Jacobian jacobian_rate(const JointVector& q, const JointVector& rate) const = 0;

  /// The arm configuration that keeps every joint in range along the whole batch: `preferred` (the arm
  /// configuration of the path before) if it does, else the first other that does. Fault of the preferred
  /// elbow if no configuration does.
  virtual std::optional<Fault> choose_configuration(const Jets& task, const ArmConfiguration& preferred,
                                                    ArmConfiguration& chosen) const = 0;

  /// One pose; throws MotionError (index 0).
  JointVector inverse(const TaskVector& pose, const ArmConfiguration& configuration) const;
  TaskVector forward(const JointVector& q) const;
};

/// Serial SCARA, RRPR [Barnett 2012, 2 and Table 2-1]: J1, J2 turn, J3 is the vertical stroke, J4 turns the
/// tool: theta_4 = phi - theta_1 - theta_2 (4.11).
struct ScaraConfig {
  double link_1_mm = 325.0;
  double link_2_mm = 275.0;
  std::array<JointRange, 4> ranges;  ///< rad, rad, mm, rad
};
ScaraConfig cobra600();  ///< 325 / 275 mm, +-105, +-150 deg, 0..210 mm, +-360 deg (720 deg of wrist in all)
std::unique_ptr<Arm> make_scara(
    const ScaraConfig& spec);  ///< throws MotionError (kLimitNotPositive, kOption)

/// Stage with 2 (x, y) or 3 (x, y, z) axes; yaw is not an axis and must stay constant.
struct CartesianConfig {
  std::vector<JointRange> ranges;  ///< mm, 2 or 3 entries
};
std::unique_ptr<Arm> make_stage(const CartesianConfig& spec);

}  // namespace firn::motion
