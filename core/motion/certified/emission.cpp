#include "core/motion/certified/emission.h"

#include <algorithm>
#include <cmath>

#include "core/motion/certified/checker.h"
#include "core/motion/certified/deviation_limits.h"
#include "core/motion/kinematics/placement.h"

namespace firn::motion {
namespace {

/// The emitted motion: segments one after another, all of it slowed down by `slow`.
class Emission {
 public:
  Emission(std::span<const StopSegment> segments, const CertifiedTask& task, EmissionWork& work)
      : segments_(segments), task_(task), work_(work) {
    start_.assign(1, 0.0);
    for (const StopSegment& segment : segments) start_.push_back(start_.back() + segment.duration_s());
  }
  double duration_s() const { return start_.back(); }
  double start_s(std::size_t segment) const { return start_[segment]; }
  std::span<const StopSegment> segments() const { return segments_; }

  /// Calls use(first sample, batch, tool, joint, segment) for the instants n * step <= the end, segment by
  /// segment.
  template <class Use>
  void at_step(double step, double slow, std::size_t count, int joints, Use&& use) {
    std::size_t n = 0;
    for (std::size_t k = 0; k + 1 < start_.size(); ++k) {
      const StopSegment& segment = segments_[k];
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
  std::span<const StopSegment> segments_;
  const CertifiedTask& task_;
  EmissionWork& work_;
  std::vector<double> start_;
};

Point2 in_part(const Jets& flange, std::size_t n, const PathInput& input, const Placement& place) {
  return {flange.of(kX, 0)[n] - place.flange_x_mm - input.origin.x_mm,
          flange.of(kY, 0)[n] - place.flange_y_mm - input.origin.y_mm};
}

/// Sets the samples at the tick. Returns the ratios seen there, as emitted.
RatioTable samples_at_tick(Emission& emission, const PathInput& input, const CertifiedTask& task,
                           EmissionWork& work, double slow, std::size_t count, PlanResult& result) {
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

void trace(Emission& emission, const PathInput& input, const CertifiedTask& task, EmissionWork& work,
           double slow, PlanResult& result) {
  const double step = task.options.trace_step_s;
  whole_ticks(emission.duration_s() * slow, step);
  const std::size_t count = std::size_t(emission.duration_s() * slow / step + 1e-9) + 1;
  result.trace.resize(count);
  double length = 0.0;
  std::size_t before = 0;
  emission.at_step(step, slow, count, std::max(task.joints, 1),
                   [&](std::size_t first, const StopSegment& segment, const StateBatch& batch, double) {
                     const std::size_t here = std::size_t(&segment - emission.segments().data());
                     for (; before < here; ++before) length += emission.segments()[before].curve.s.back();
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

}  // namespace

void emit(const PathInput& input, const CertifiedTask& task, std::span<const StopSegment> segments,
          EmissionWork& work, PlanResult& result) {
  const PlanOptions& options = task.options;
  const Arm& arm = task.arm;
  Emission emission(segments, task, work);
  result.continuous_s = emission.duration_s();
  RatioTable inside;
  double start = 0.0;
  Certificate& certificate = result.trajectory.certificate;
  for (const StopSegment& segment : segments) {
    RatioTable here = segment.ratios;
    here.scale_time(segment.factor);
    inside.merge(here, start);
    start += segment.duration_s();
    certificate.lower_bound_s += options.lower_bound ? segment.bound_s : 0.0;
    result.deviation_mm = std::max(result.deviation_mm, segment.deviation_mm);
    result.points_off_mm = std::max(result.points_off_mm, segment.points_off_mm);
  }
  result.held_mm = hold_mm(options);
  result.stops = segments.size() - 1;
  Trajectory& trajectory = result.trajectory;
  trajectory.tick_s = options.tick_s;
  trajectory.axes = arm.joints();
  for (int j = 0; j < arm.joints(); ++j) trajectory.axis_units.push_back(arm.joint_unit(j));
  double needed = 1.0 + kDerivativeRounding;
  for (int tries = 0;; ++tries) {
    const std::size_t ticks = whole_ticks(needed * emission.duration_s(), options.tick_s);
    const double slow = double(ticks) * options.tick_s / emission.duration_s();
    RatioTable seen = samples_at_tick(emission, input, task, work, slow, ticks + 1, result);
    seen.merge(difference_ratios(trajectory, result.tool, result.yaw_rad, task.groups), 0.0);
    if (const double factor = seen.time_factor(); factor > 1.0 && tries < kMaxEmissionTries) {
      needed = slow * factor;
      continue;
    }
    inside.scale_time(slow);
    seen.merge(inside, 0.0);
    fill_certificate(seen, task.groups, arm, certificate);
    certificate.duration_s = double(ticks) * options.tick_s;
    for (std::size_t k = 1; k < segments.size(); ++k)
      result.stop_samples.push_back(std::size_t(std::llround(slow * emission.start_s(k) / options.tick_s)));
    if (options.trace_step_s > 0.0) trace(emission, input, task, work, slow, result);
    break;
  }
  certificate.curvature_ramp_mm = options.curvature_ramp_mm;
}

}  // namespace firn::motion
