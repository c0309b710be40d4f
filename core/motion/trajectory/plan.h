// PlanOptions and PlanResult hold the options and the result of planning one path by any method.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/fault.h"
#include "core/motion/kinematics/limits.h"
#include "core/path/path.h"

namespace firn::motion {

enum class Method {
  kCertified,  ///< fast tier: within the limits, close to the minimum time
               ///< (docs/algorithms/certified-motion.md)
  kOptimal,    ///< slow tier: the same problem on a fine grid, solved to convergence
  kThesis,     ///< [Barnett 2012, 4.1]: VCON, ACON, JCON, AREST
  kConstant,   ///< constant speed with stops, the baseline of 4.2 and 4.4
  kDefault     ///< as the V+ controller without MTTS (Figs. 4-12 to 4-14)
};
const char* name(Method method);                       ///< "certified", "optimal", …
std::optional<Method> method_named(std::string_view);  ///< nullopt: no such method

/// Distance of the curve from the points without a tolerance, for methods certified and optimal.
enum class PointRule {
  kRamped,  ///< may leave points where curvature jumps and at slight corners, by about curvature_ramp_mm / 10
  kHeld,    ///< passes every point within its rounding, but for PlanOptions::kMinHold_mm
  kFaster   ///< of the two
};

struct PlanOptions {
  Method method = Method::kCertified;
  double tolerance_mm = 0.0;    ///< > 0: corners may be rolled and curvature ramped within this deviation
  double point_noise_mm = 0.0;  ///< largest rounding of a coordinate of the points, 0 = none
  PointRule point_rule = PointRule::kRamped;
  static constexpr double kMinHold_mm = 2e-4;
  double slack = 0.0;  ///< certified: work ends where a motion is slower than it might be by about this share
  double tick_s = 0.016;  ///< period of the emitted samples
  double curvature_ramp_mm =
      0.4;  ///< w: every jump of curvature is ramped over this length (errata, chapter 4)
  double split_angle_rad = 0.5235987755982988;  ///< sharper corners are stops (PATHSPLIT), 30 degrees
  double trace_step_s = 0.0;          ///< > 0: PlanResult::trace is filled, with this spacing or at the tick
  double constant_fill_mm_s = 100.0;  ///< method constant: straight fill, 100 in 4.2 and 125 in 4.4
  bool lower_bound = true;            ///< fill Certificate::lower_bound_s
  bool axis_rates = false;            ///< fill PlanResult::axis_rates
  bool bound_without_jerk = false;    ///< with a bound for motions that exceed the jerk limit, too
};

/// The continuous motion at one instant, for plots: norms of the Cartesian derivatives and joint derivatives.
struct TraceSample {
  double t_s = 0.0;
  double s_mm = 0.0;                                      ///< along the path
  Point2 at;                                              ///< tool, in the frame of the path handed in
  std::array<double, 3> total{};                          ///< speed, acceleration, jerk: mm/s, mm/s^2, mm/s^3
  std::array<std::array<double, 3>, kMaxJoints> joint{};  ///< rate, acceleration, jerk, signed
};

struct PlanResult {
  std::optional<Fault> fault;   ///< set: no trajectory, and this is the named reason
  Trajectory trajectory;        ///< all joints at the tick; sample 0 = start at rest, last = end at rest
  std::vector<Point2> tool;     ///< tool position of each sample, in the frame of the path handed in
  std::vector<double> yaw_rad;  ///< of the tool at each sample; empty where it is constant
  /// Velocities of the axes at the samples, as Trajectory::positions [axis unit / s]: of the continuous
  /// motion, or central differences where a method has none. Empty unless asked for.
  std::vector<double> axis_rates;
  ArmConfiguration configuration;         ///< of this path: hand it to the next one as PathInput::preferred
  double continuous_s = 0.0;              ///< duration before rounding up to whole ticks
  double deviation_mm = 0.0;              ///< largest distance of the motion's curve from the path handed in
  double held_mm = 0.0;                   ///< distance within which the points are held, 0 = they are not
  double points_off_mm = 0.0;             ///< largest distance of a held point from the curve, in order
  std::size_t stops = 0;                  ///< corners where the motion comes to rest (ends not counted)
  std::vector<std::size_t> stop_samples;  ///< the sample nearest to each stop
  std::vector<TraceSample> trace;         ///< empty unless asked for

  bool ok() const { return !fault; }
};

}  // namespace firn::motion
