#include "core/motion/certified.h"

#include <algorithm>
#include <cmath>

#include "core/motion/deviation.h"

namespace firn::motion {
namespace {

struct Effort {
  CellSizes sizes;
  ProfileOptions solver;
  int inner_checks;
};

Effort effort(Method method) {
  if (method != Method::kOptimal) return {CellSizes{}, ProfileOptions{}, 1};
  CellSizes fine;
  fine.ramp_cells = 32;
  fine.ramp_exit_mm = 0.02;
  fine.growth = 1.08;
  fine.rest_growth = 1.04;
  fine.largest_mm = 0.6;
  fine.arc_angle_rad = 0.015;
  fine.rest_mm = 0.01;
  ProfileOptions converged;
  converged.gap = 1e-4;
  converged.most_iterations = 80;
  return {fine, converged, 2};
}

/// Ratios of the motion in `out` at both ends and inside of every piece.
void check(const CertifiedTask& task, int inner, CertifiedWork& work, Stretch& out) {
  check_states(out.curve, out.motion, inner, work.batch);
  if (auto fault = sample_motion(out.curve, work.batch, task.arm, task.placement, task.joints, work.tool,
                                 work.joint)) {
    fault->index = out.first;
    throw MotionError(*fault);
  }
  out.ratios = {};
  add_ratios(out.curve, work.batch, work.tool, work.joint, task.groups, out.ratios);
  out.factor = out.ratios.time_factor();
}

/// The closed form on a line, where no joint binds. False: something else binds, or the ceiling varies.
bool plan_straight(const CertifiedTask& task, CertifiedWork& work, Stretch& out) {
  const double ceiling = out.curve.ceiling[0];
  for (const double c : out.curve.ceiling)
    if (c != ceiling) return false;
  const RateLimits& limit = task.limits.position;
  straight_motion(out.curve.s.back(), std::min(limit.rate, ceiling), limit.acceleration, limit.jerk,
                  out.motion);
  check(task, 3, work, out);
  if (!(out.factor <= 1.0 + 1e-9)) return false;
  out.factor = 1.0;
  return true;
}

}  // namespace

void plan_stretch(std::span<const Point2> points, std::span<const double> ceiling, const CertifiedTask& task,
                  CertifiedWork& work, Stretch& out) {
  const Effort effort = motion::effort(task.options.method);
  CurveSpec spec{task.options.curvature_ramp_mm, task.options.tolerance_mm, effort.sizes};
  build_curve(points, ceiling, spec, work.curve, out.curve);
  for (int tries = 0; spec.tolerance_mm > 0.0; ++tries) {
    out.deviation_mm = deviation(out.curve, points, work.length);
    if (out.deviation_mm <= task.options.tolerance_mm || tries == 6) break;
    spec.tolerance_mm *= std::min(0.9, 0.98 * task.options.tolerance_mm / out.deviation_mm);
    build_curve(points, ceiling, spec, work.curve, out.curve);
  }
  if (!(spec.tolerance_mm > 0.0))
    out.deviation_mm = out.curve.straight ? 0.0 : deviation(out.curve, points, work.length);
  const auto bound = [&] {
    if (auto fault = compute_rows(out.curve, task.arm, task.placement, task.joints, work.rows)) {
      fault->index = out.first;
      throw MotionError(*fault);
    }
    speed_bound(out.curve, work.rows, task.groups, work.bound);
    out.bound_s = work.bound.duration_s;
  };
  if (out.curve.straight && plan_straight(task, work, out)) {
    if (task.options.lower_bound) bound();
    return;
  }
  bound();
  solve_profile(out.curve, work.rows, task.groups, work.bound.limit, work.bound.b, effort.solver, work.solver,
                work.profile);
  time_profile(out.curve, work.profile, out.motion);
  check(task, effort.inner_checks, work, out);
  if (out.factor < 1.05) return;
  // The solver did not converge: its first guess, slowed down, always serves.
  Stretch guess;
  guess.curve = out.curve;
  guess.first = out.first;
  ProfileOptions none = effort.solver;
  none.most_iterations = 0;
  solve_profile(out.curve, work.rows, task.groups, work.bound.limit, work.bound.b, none, work.solver,
                work.profile);
  time_profile(guess.curve, work.profile, guess.motion);
  check(task, effort.inner_checks, work, guess);
  if (!(guess.duration_s() < out.duration_s())) {
    if (std::isfinite(out.duration_s())) return;
    throw MotionError(Fault(Reason::kNoSolution));
  }
  out.motion = std::move(guess.motion);
  out.ratios = guess.ratios;
  out.factor = guess.factor;
}

}  // namespace firn::motion
