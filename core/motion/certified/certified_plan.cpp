// From segments to a trajectory: whole ticks, samples, certificate.
#include <algorithm>
#include <cmath>

#include "core/motion/certified/certified.h"
#include "core/motion/certified/checker.h"
#include "core/motion/kinematics/placement.h"
#include "core/motion/kinematics/require.h"

namespace firn::motion {
namespace {

Placement placement(const PathInput& input, const CleanPath& path) {
  if (!path.yaw_rad.empty()) {
    Placement place;
    place.z_mm = input.z_mm;
    place.turning = true;
    place.tool = input.tool;
    return place;
  }
  const double yaw = input.yaw_point_rad.empty() ? input.yaw_rad : input.yaw_point_rad.front();
  Jets pose(kTaskAxes, 1);
  for (int axis = 0; axis < kTaskAxes; ++axis)
    for (int order = 0; order < 4; ++order) pose.of(axis, order)[0] = 0.0;
  pose.of(kYaw, 0)[0] = yaw;
  tool_to_flange(input.tool, pose, pose);
  Placement place;
  place.z_mm = input.z_mm;
  place.yaw_rad = yaw;
  place.flange_x_mm = pose.of(kX, 0)[0];
  place.flange_y_mm = pose.of(kY, 0)[0];
  place.flange_z_mm = pose.of(kZ, 0)[0];
  return place;
}

/// The arm configuration is chosen on some of the points first: every sample's joints are checked later in
/// any case.
ArmConfiguration configuration(const CleanPath& path, const PathInput& input, const Arm& arm) {
  constexpr std::size_t kEvery = 16;
  if (path.points.size() < 4 * kEvery) return configuration_for(path, input, arm);
  CleanPath some;
  for (std::size_t i = 0; i < path.points.size();
       i +=
       i + kEvery < path.points.size() || i + 1 == path.points.size() ? kEvery : path.points.size() - 1 - i) {
    some.points.push_back(path.points[i]);
    some.source.push_back(path.source[i]);
    if (!path.yaw_rad.empty()) some.yaw_rad.push_back(path.yaw_rad[i]);
  }
  return configuration_for(some, input, arm);
}

void check_options(const PlanOptions& options) {
  require(options.tick_s > 0.0 && options.tick_s <= 10.0, Reason::kOption, "tick", options.tick_s, 0.0);
  require(options.tolerance_mm >= 0.0 && options.tolerance_mm <= 10.0, Reason::kOption, "tolerance",
          options.tolerance_mm, 0.0);
  require(options.curvature_ramp_mm >= 0.01 && options.curvature_ramp_mm <= 100.0, Reason::kOption,
          "curvature ramp", options.curvature_ramp_mm, 0.01);
  require(options.split_angle_rad > 0.0 && options.split_angle_rad <= 3.2, Reason::kOption, "split angle",
          options.split_angle_rad, 0.0);
}

/// A motion of more ticks than memory holds is refused before it is planned: it takes at least its length
/// over its speed limit. Differences of samples closer than kLeastTickS show the rounding of their values.
void check_ticks(const CleanPath& path, const MotionLimits& limits, const PlanOptions& options) {
  constexpr double kLeastTickS = 1e-5;
  double least_s = 0.0;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const double dx = path.points[i + 1].x_mm - path.points[i].x_mm,
                 dy = path.points[i + 1].y_mm - path.points[i].y_mm;
    least_s += std::sqrt(dx * dx + dy * dy) / std::min(path.speed_limit_mm_s[i], limits.position.rate);
  }
  whole_ticks(least_s, options.tick_s);
  if (options.trace_step_s > 0.0) whole_ticks(least_s, options.trace_step_s);
  require(options.tick_s >= kLeastTickS, Reason::kOption, "tick", options.tick_s, kLeastTickS);
}

/// The emitted motion: segments one after another, all of it slowed down by `slow`.
class Emission {
 public:
  Emission(std::size_t segments, const CertifiedTask& task, CertifiedWork& work) : task_(task), work_(work) {
    start_.assign(1, 0.0);
    for (std::size_t k = 0; k < segments; ++k)
      start_.push_back(start_.back() + work.segments[k].duration_s());
  }
  double duration_s() const { return start_.back(); }
  double start_s(std::size_t segment) const { return start_[segment]; }

  /// Calls use(first sample, batch, tool, joint, segment) for the instants n * step <= the end, segment by
  /// segment.
  template <class Use>
  void at_step(double step, double slow, std::size_t count, int joints, Use&& use) {
    std::size_t n = 0;
    for (std::size_t k = 0; k + 1 < start_.size(); ++k) {
      const StopSegment& segment = work_.segments[k];
      const TimedMotion& motion = segment.motion;
      StateBatch& batch = work_.batch;
      batch.clear();
      const std::size_t first = n;
      std::size_t piece = 0, cell = 0;
      const double end = k + 2 == start_.size() ? 1e300 : start_[k + 1];
      for (; n < count && double(n) * step / slow < end; ++n) {
        const double at =
            std::clamp((double(n) * step / slow - start_[k]) / segment.factor, 0.0, motion.t.back());
        while (piece + 1 < motion.pieces() && at >= motion.t[piece + 1]) ++piece;
        const PathState q = motion.state(piece, at);
        while (cell + 1 < segment.curve.cells() && q.s >= segment.curve.s[cell + 1]) ++cell;
        batch.state.push_back(q);
        batch.cell.push_back(cell);
        batch.time.push_back(at);
      }
      if (batch.size() == 0) continue;
      if (auto fault = sample_motion(segment.curve, batch, task_.arm, task_.placement, joints, true,
                                     work_.tool, work_.joint, work_.flange)) {
        throw MotionError(*fault);
      }
      use(first, segment, batch, start_[k]);
    }
  }

 private:
  const CertifiedTask& task_;
  CertifiedWork& work_;
  std::vector<double> start_;
};

Point2 in_part(const Jets& flange, std::size_t n, const PathInput& input, const Placement& place) {
  return {flange.of(kX, 0)[n] - place.flange_x_mm - input.origin.x_mm,
          flange.of(kY, 0)[n] - place.flange_y_mm - input.origin.y_mm};
}

/// Samples at the tick. Returns the ratios seen there, as emitted.
RatioTable emit(Emission& emission, const PathInput& input, const CertifiedTask& task, CertifiedWork& work,
                double slow, std::size_t count, PlanResult& result) {
  const int axes = task.arm.joints();
  Trajectory& trajectory = result.trajectory;
  trajectory.positions.resize(count * std::size_t(axes));
  result.axis_rates.resize(task.options.axis_rates ? trajectory.positions.size() : 0);
  result.tool.resize(count);
  result.yaw_rad.resize(task.placement.turning ? count : 0);
  RatioTable table;
  emission.at_step(task.options.tick_s, slow, count, axes,
                   [&](std::size_t first, const StopSegment& segment, const StateBatch& batch, double start) {
                     for (std::size_t n = 0; n < batch.size(); ++n) {
                       for (int j = 0; j < axes; ++j)
                         trajectory.positions[(first + n) * std::size_t(axes) + std::size_t(j)] =
                             work.joint.of(j, 0)[n];
                       if (task.options.axis_rates)
                         for (int j = 0; j < axes; ++j)
                           result.axis_rates[(first + n) * std::size_t(axes) + std::size_t(j)] =
                               work.joint.of(j, 1)[n] / (segment.factor * slow);
                       result.tool[first + n] = in_part(work.tool, n, input, task.placement);
                       if (task.placement.turning) result.yaw_rad[first + n] = work.tool.of(kYaw, 0)[n];
                     }
                     RatioTable here;
                     add_ratios(segment.curve, batch, work.tool, work.joint, task.groups, here);
                     here.scale_time(segment.factor);
                     table.merge(here, start);
                   });
  table.scale_time(slow);
  return table;
}

void trace(Emission& emission, const PathInput& input, const CertifiedTask& task, CertifiedWork& work,
           double slow, PlanResult& result) {
  const double step = task.options.trace_step_s;
  whole_ticks(emission.duration_s() * slow, step);
  const std::size_t count = std::size_t(emission.duration_s() * slow / step + 1e-9) + 1;
  result.trace.resize(count);
  double length = 0.0;
  std::size_t before = 0;
  emission.at_step(step, slow, count, std::max(task.joints, 1),
                   [&](std::size_t first, const StopSegment& segment, const StateBatch& batch, double) {
                     const std::size_t here = std::size_t(&segment - work.segments.data());
                     for (; before < here; ++before) length += work.segments[before].curve.s.back();
                     const double scale = 1.0 / (segment.factor * slow);
                     for (std::size_t n = 0; n < batch.size(); ++n) {
                       TraceSample& sample = result.trace[first + n];
                       sample.t_s = double(first + n) * step;
                       sample.s_mm = length + batch.state[n].s;
                       sample.at = in_part(work.tool, n, input, task.placement);
                       double power = 1.0;
                       for (int k = 0; k < 3; ++k) {
                         power *= scale;
                         const double x = work.tool.of(kX, k + 1)[n], y = work.tool.of(kY, k + 1)[n];
                         sample.total[std::size_t(k)] = power * std::sqrt(x * x + y * y);
                         for (int j = 0; j < task.joints; ++j)
                           sample.joint[std::size_t(j)][std::size_t(k)] = power * work.joint.of(j, k + 1)[n];
                       }
                     }
                   });
}

/// The arm refused a flange position of the curve: names the input's nearest point, in the input's frame.
Fault in_input(Fault fault, const CleanPath& path, const PathInput& input, const Placement& place) {
  if (fault.reason == Reason::kNoSolution) return fault;
  if (fault.reason == Reason::kPathDeviation) {
    fault.index = path.source[fault.index];
    fault.at = input.points[fault.index];
    return fault;
  }
  fault.at.x_mm -= place.flange_x_mm;
  fault.at.y_mm -= place.flange_y_mm;
  const auto squared = [&](std::size_t i) {
    const double dx = path.points[i].x_mm - fault.at.x_mm, dy = path.points[i].y_mm - fault.at.y_mm;
    return dx * dx + dy * dy;
  };
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < path.points.size(); ++i)
    if (squared(i) < squared(nearest)) nearest = i;
  fault.index = path.source[nearest];
  fault.at.x_mm -= input.origin.x_mm;
  fault.at.y_mm -= input.origin.y_mm;
  return fault;
}

/// From planned segments to the result: whole ticks, samples, certificate, trace.
void finish(const PathInput& input, const CertifiedTask& task, std::size_t segments, CertifiedWork& work,
            PlanResult& result) {
  const PlanOptions& options = task.options;
  const Arm& arm = task.arm;
  Emission emission(segments, task, work);
  result.continuous_s = emission.duration_s();
  RatioTable inside;
  double start = 0.0;
  Certificate& certificate = result.trajectory.certificate;
  for (std::size_t k = 0; k < segments; ++k) {
    const StopSegment& segment = work.segments[k];
    RatioTable here = segment.ratios;
    here.scale_time(segment.factor);
    inside.merge(here, start);
    start += segment.duration_s();
    certificate.lower_bound_s += options.lower_bound ? segment.bound_s : 0.0;
    result.deviation_mm = std::max(result.deviation_mm, segment.deviation_mm);
    result.points_off_mm = std::max(result.points_off_mm, segment.points_off_mm);
  }
  result.held_mm = hold_mm(options);
  result.stops = segments - 1;
  Trajectory& trajectory = result.trajectory;
  trajectory.tick_s = options.tick_s;
  trajectory.axes = arm.joints();
  for (int j = 0; j < arm.joints(); ++j) trajectory.axis_units.push_back(arm.joint_unit(j));
  constexpr double kRounding = 4e-9;  // more than sums of the motion's derivatives lose
  const bool proved = options.curve_rule == CurveRule::kFitted;
  const double most = proved ? 1.0 : 1.0002;
  double needed = proved ? 1.0 + kRounding : 1.0;
  for (int tries = 0;; ++tries) {
    const std::size_t ticks = whole_ticks(needed * emission.duration_s(), options.tick_s);
    const double slow = double(ticks) * options.tick_s / emission.duration_s();
    RatioTable seen = emit(emission, input, task, work, slow, ticks + 1, result);
    if (proved) seen.merge(difference_ratios(trajectory, result.tool, result.yaw_rad, task.groups), 0.0);
    if (const double factor = seen.time_factor(); factor > most && tries < 4) {
      needed = slow * factor;
      continue;
    }
    inside.scale_time(slow);
    seen.merge(inside, 0.0);
    if (!proved) seen.merge(difference_ratios(trajectory, result.tool, result.yaw_rad, task.groups), 0.0);
    fill_certificate(seen, task.groups, arm, certificate);
    certificate.duration_s = double(ticks) * options.tick_s;
    for (std::size_t k = 1; k < segments; ++k)
      result.stop_samples.push_back(std::size_t(std::llround(slow * emission.start_s(k) / options.tick_s)));
    if (options.trace_step_s > 0.0) trace(emission, input, task, work, slow, result);
    break;
  }
  certificate.curvature_ramp_mm = options.curvature_ramp_mm;
}

}  // namespace

double farthest_mm(const PlanOptions& options) {
  return options.tolerance_mm + 0.5 * options.curvature_ramp_mm + kSagittaMm;
}

void keep_near(const StopSegment& segment, const PlanOptions& options) {
  if (segment.deviation_mm <= farthest_mm(options)) return;
  Fault fault(Reason::kPathDeviation);
  fault.index = segment.first;
  fault.value = segment.deviation_mm;
  fault.bound = farthest_mm(options);
  throw MotionError(fault);
}

PlanResult plan_certified(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                          const PlanOptions& options, CertifiedWork& work) {
  check_options(options);
  check_limits(limits, arm.joints());
  const CleanPath path = clean(input);
  check_ticks(path, limits, options);
  const ArmConfiguration chosen = configuration(path, input, arm);
  CertifiedTask task{arm, limits, options, placement(input, path), limited_joints(limits, arm.joints()), {}};
  task.groups = row_groups(limits, task.joints, task.placement.turning);
  PlanResult result;
  result.configuration = task.placement.configuration = chosen;
  try {
    const std::size_t segments = plan_segments(path, task, work);
    for (std::size_t k = 0; k < segments; ++k) {
      StopSegment& segment = work.segments[k];
      if (options.curve_rule == CurveRule::kFitted) prove(task, work, segment);
      keep_near(segment, options);
    }
    finish(input, task, segments, work, result);
  } catch (const MotionError& error) {
    throw MotionError(in_input(error.fault(), path, input, task.placement));
  }
  return result;
}

}  // namespace firn::motion
