#include "core/motion/planner.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/motion/certified/certified.h"
#include "core/motion/certified/checker.h"
#include "core/motion/constant_speed.h"
#include "core/motion/curve/deviation.h"
#include "core/motion/curve/given_curves.h"
#include "core/motion/kinematics/placement.h"
#include "core/motion/sampled_trace.h"
#include "core/motion/thesis/thesis.h"
#include "core/motion/vplus_default.h"

namespace firn::motion {
namespace {

constexpr std::array<std::pair<Method, const char*>, 5> kMethods{{{Method::kCertified, "certified"},
                                                                  {Method::kOptimal, "optimal"},
                                                                  {Method::kThesis, "thesis"},
                                                                  {Method::kConstant, "constant"},
                                                                  {Method::kDefault, "default"}}};

Trajectory sampled(const PathInput& path, const Arm& arm, const MotionLimits& limits,
                   const PlanOptions& options) {
  if (options.method == Method::kThesis) {
    ThesisOptions thesis;
    thesis.tick_s = options.tick_s;
    thesis.split.split_angle_rad = options.split_angle_rad;
    thesis.rest.step_s = 0.5 * options.tick_s;
    return plan_thesis(path, arm, limits, thesis);
  }
  if (options.method == Method::kConstant) {
    ConstantOptions constant;
    constant.tick_s = options.tick_s;
    constant.fill_mm_s = options.constant_fill_mm_s;
    constant.split_angle_rad = options.split_angle_rad;
    return plan_constant(path, arm, limits, constant);
  }
  DefaultOptions vplus;
  vplus.tick_s = options.tick_s;
  return plan_default(path, arm, limits, vplus);
}

/// For each stop the sample nearest to it, one after another along the path.
std::vector<std::size_t> samples_at(const std::vector<std::size_t>& stops, const CleanPath& path,
                                    Point2 origin, const std::vector<Point2>& tool) {
  constexpr double kNearMm = 1.0;  // of path: shortening by rounded corners and chords across arcs
  std::vector<std::size_t> found;
  double along = 0.0, driven = 0.0;
  std::size_t n = 0, point = 0;
  for (const std::size_t stop : stops) {
    for (; point < stop; ++point) along += distance(path.points[point], path.points[point + 1]);
    while (n + 1 < tool.size() && driven < along - kNearMm) {
      driven += distance(tool[n], tool[n + 1]);
      ++n;
    }
    const Point2 at{path.points[stop].x_mm - origin.x_mm, path.points[stop].y_mm - origin.y_mm};
    std::size_t nearest = n;
    double ahead = driven;
    for (std::size_t k = n; k < tool.size() && ahead <= along + kNearMm; ++k) {
      if (distance(tool[k], at) < distance(tool[nearest], at)) nearest = k;
      if (k + 1 < tool.size()) ahead += distance(tool[k], tool[k + 1]);
    }
    found.push_back(nearest);
  }
  return found;
}

/// Velocities by central differences; the motion begins and ends at rest.
std::vector<double> central_rates(const Trajectory& t) {
  const std::size_t axes = std::size_t(t.axes), last = t.samples();
  std::vector<double> rates(t.positions.size(), 0.0);
  for (std::size_t n = 1; n + 1 < last; ++n)
    for (std::size_t a = 0; a < axes; ++a)
      rates[n * axes + a] =
          (t.positions[(n + 1) * axes + a] - t.positions[(n - 1) * axes + a]) / (2.0 * t.tick_s);
  return rates;
}

/// Methods that know only their samples: the checker takes differences.
PlanResult checked(Trajectory trajectory, const PathInput& path, const Arm& arm, const MotionLimits& limits,
                   const PlanOptions& options) {
  PlanResult result;
  CleanPath clean_path = clean(path);
  result.configuration = configuration_for(clean_path, path, arm);
  std::vector<std::size_t> stops{0, clean_path.points.size() - 1};
  if (options.method == Method::kThesis)
    stops = with_stops(thesis::split_points(clean_path.points, options.split_angle_rad), clean_path);
  if (options.method == Method::kConstant)
    stops = with_stops(fill_stops(clean_path.points, path.kind, options.split_angle_rad), clean_path);
  stops = {stops.begin() + 1, stops.end() - 1};
  result.stops = stops.size();
  const std::size_t count = trajectory.samples(), axes = std::size_t(trajectory.axes);
  Jets joints(trajectory.axes, count), pose(kTaskAxes, count);
  for (int j = 0; j < trajectory.axes; ++j)
    for (int order = 0; order < 4; ++order)
      for (std::size_t n = 0; n < count; ++n)
        joints.of(j, order)[n] = order == 0 ? trajectory.positions[n * axes + std::size_t(j)] : 0.0;
  arm.forward(joints, pose);
  flange_to_tool(path.tool, pose, pose);
  const bool turning = !clean_path.yaw_rad.empty();
  if (turning)
    for (std::size_t n = 0; n < count; ++n)
      result.yaw_rad.push_back(pose.of(kYaw, 0)[n] - 2.0 * std::numbers::pi * result.configuration.yaw_turns);
  for (std::size_t n = 0; n < count; ++n)
    result.tool.push_back({pose.of(kX, 0)[n] - path.origin.x_mm, pose.of(kY, 0)[n] - path.origin.y_mm});
  result.stop_samples = samples_at(stops, clean_path, path.origin, result.tool);
  std::vector<Point2> buffer;
  const GivenReference reference = sample_given(clean_path.points, clean_path.given, buffer);
  std::vector<Point2> in_part(reference.points.begin(), reference.points.end());
  for (Point2& p : in_part) p = {p.x_mm - path.origin.x_mm, p.y_mm - path.origin.y_mm};
  result.deviation_mm = deviation(result.tool, in_part) + reference.sagitta_mm;
  const RowGroups groups = row_groups(limits, limited_joints(limits, arm.joints()), turning);
  fill_certificate(difference_ratios(trajectory, result.tool, result.yaw_rad, groups), groups, arm,
                   trajectory.certificate);
  if (options.trace_step_s > 0.0) result.trace = sampled_trace(trajectory, result.tool);
  if (options.axis_rates) result.axis_rates = central_rates(trajectory);
  result.continuous_s = trajectory.certificate.duration_s =
      count > 1 ? double(count - 1) * trajectory.tick_s : 0.0;
  result.trajectory = std::move(trajectory);
  return result;
}

}  // namespace

struct PlanWorkspace::State {
  CertifiedWork certified;
};

PlanWorkspace::PlanWorkspace() : state_(std::make_unique<State>()) {}
PlanWorkspace::~PlanWorkspace() = default;
PlanWorkspace::PlanWorkspace(PlanWorkspace&&) noexcept = default;
PlanWorkspace& PlanWorkspace::operator=(PlanWorkspace&&) noexcept = default;

const char* name(Method method) {
  for (const auto& [m, text] : kMethods)
    if (m == method) return text;
  return "unknown";
}

std::optional<Method> method_named(std::string_view text) {
  for (const auto& [m, known] : kMethods)
    if (text == known) return m;
  return std::nullopt;
}

namespace {

/// The lower bound holds for the path with its stops by any method, but not for one that cuts corners.
void bound(const PathInput& path, const Arm& arm, const MotionLimits& limits, PlanOptions options,
           CertifiedWork& work, Certificate& certificate) {
  if (!options.lower_bound || options.method == Method::kDefault) return;
  options.method = Method::kCertified;
  options.bound_without_jerk = true;
  options.tolerance_mm = options.trace_step_s = 0.0;
  try {
    const PlanResult best = plan_certified(path, arm, limits, options, work);
    certificate.lower_bound_s = best.trajectory.certificate.lower_bound_s;
    certificate.curvature_ramp_mm = options.curvature_ramp_mm;
  } catch (const MotionError&) {  // this method found a way where the certified one has none: no bound
  }
}

}  // namespace

PlanResult plan(const PathInput& path, const Arm& arm, const MotionLimits& limits, const PlanOptions& options,
                PlanWorkspace& work) {
  try {
    const bool exact = options.method == Method::kCertified || options.method == Method::kOptimal;
    if (exact && options.point_rule == PointRule::kFaster && !(options.tolerance_mm > 0.0))
      return plan_faster(path, arm, limits, options, work.state().certified);
    if (exact) return plan_certified(path, arm, limits, options, work.state().certified);
    PlanResult result = checked(sampled(path, arm, limits, options), path, arm, limits, options);
    bound(path, arm, limits, options, work.state().certified, result.trajectory.certificate);
    return result;
  } catch (const MotionError& error) {
    PlanResult refused;
    refused.fault = error.fault();
    return refused;
  }
}

PlanResult plan(const PathInput& path, const Arm& arm, const MotionLimits& limits,
                const PlanOptions& options) {
  PlanWorkspace work;
  return plan(path, arm, limits, options, work);
}

}  // namespace firn::motion
