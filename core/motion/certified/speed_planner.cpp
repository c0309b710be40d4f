#include "core/motion/certified/speed_planner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/certified/deviation_limits.h"

namespace firn::motion {

/// Effort of the speed profile: the sizes of its cells and the options of its solver.
struct SpeedPlanner::Effort {
  CellSizes sizes;
  ProfileOptions solver;
  int inner_checks = 1;
};

/// When the check shows that a limit is exceeded between the places where the solver looked, or the solver
/// did not converge, the next attempt is finer. Times that descent compares are all as exact.
SpeedPlanner::Effort SpeedPlanner::effort(const CertifiedTask& task, int attempt) {
  Effort e;
  const bool optimal = task.options.method == Method::kOptimal;
  if (optimal) {
    e.sizes.rest_growth = kOptimalRestGrowth;
    e.sizes.rest_mm = kOptimalRest_mm;
    e.sizes.split = kOptimalSplit;
    e.sizes.min_mm = kOptimalMinCell_mm;
    e.solver.gap = kOptimalGap;
    e.solver.max_iterations = kOptimalIterations;
    e.inner_checks = kOptimalInnerChecks;
  } else if (task.in_descent || moves_within_tolerance(task.options)) {
    e.sizes.split = kToleranceSplit;
    e.solver.gap = task.in_descent ? kDescentGap : kToleranceGap;
  }
  if (attempt > 0) {
    e.solver.max_iterations = kOptimalIterations;
    if (optimal || !task.in_descent) e.solver.gap *= kRetryGapFactor;
  }
  return e;
}

namespace {

/// The tool's motion, and the joints that may come near a limit while the tool keeps its own: joints whose
/// q' times the tool's largest rate, acceleration and jerk stays well below theirs come last.
struct ActiveGroups {
  RowGroups groups;
  int active = 1;  ///< the first so many
};
ActiveGroups active_groups(const MotionRows& rows, const RowGroups& all) {
  const RateLimits& tool = all.group[0].limit;
  ActiveGroups order{all, 1};
  for (int g = 1; g < all.count; ++g) {
    const RateLimits& limit = all.group[g].limit;
    const double max_inactive = std::min({kInactiveRateShare * limit.rate / tool.rate,
                                          kInactiveShare * limit.acceleration / tool.acceleration,
                                          kInactiveShare * limit.jerk / tool.jerk});
    const std::vector<double>& slope = rows.of[all.group[g].first][0];
    double max_slope = 0.0;
    for (const double d1 : slope) max_slope = std::max(max_slope, std::abs(d1));
    if (max_slope > max_inactive) std::swap(order.groups.group[order.active++], order.groups.group[g]);
  }
  return order;
}

/// Largest factor by which time must be stretched for the groups after the first `active` ones.
double inactive_factor(const RatioTable& ratios, const RowGroups& all, const RowGroups& order, int active) {
  double factor = 0.0;
  for (int g = 0; g < all.count; ++g)
    for (int k = active; k < order.count; ++k)
      if (order.group[k].first == all.group[g].first) factor = std::max(factor, factor_of(ratios.ratio[g]));
  return factor;
}

/// Speed along the chord from points[i] at which the tool turns as fast as it may.
double turning_speed(const PathPart& part, std::size_t i, const MotionLimits& limits) {
  if (part.yaw_rad.empty()) return kUnlimited;
  const Point2 &a = part.points[i], &b = part.points[i + 1];
  const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm;
  const double turn = std::abs(part.yaw_rad[i + 1] - part.yaw_rad[i]);
  return turn > 0.0 ? limits.orientation.rate * std::sqrt(dx * dx + dy * dy) / turn : kUnlimited;
}

/// The first cell at rest, shorter where a low speed is reached within it: v^(3/2) / j^(1/2) from rest.
double rest_cell_mm(double size_mm, double speed_mm_s, const RateLimits& limit) {
  const double v = std::min(limit.rate, speed_mm_s);
  return std::min(size_mm, std::max(kMinRestCell_mm, kRestCellShare * v * std::sqrt(v / limit.jerk)));
}

/// Gives `to` the ends of `from` and its distances from the path.
void take_path_of(const StopSegment& from, StopSegment& to) {
  to.first = from.first;
  to.last = from.last;
  to.deviation_mm = from.deviation_mm;
  to.points_off_mm = from.points_off_mm;
}

}  // namespace

CellSizes SpeedPlanner::cell_sizes(const PathPart& part, const CertifiedTask& task) {
  CellSizes sizes = effort(task, 0).sizes;
  const std::size_t last = part.points.size() - 2;
  const double low_mm_s = std::max(std::min(part.speed_limit.front(), turning_speed(part, 0, task.limits)),
                                   std::min(part.speed_limit.back(), turning_speed(part, last, task.limits)));
  sizes.rest_mm = rest_cell_mm(sizes.rest_mm, low_mm_s, task.limits.position);
  return sizes;
}

void SpeedPlanner::set_rows(const CertifiedTask& task, const StopSegment& out) {
  if (auto fault = compute_rows(out.curve, task.arm, task.placement, task.joints, rows_))
    throw MotionError(*fault);
}

void SpeedPlanner::sample(const CertifiedTask& task, int inner, const StopSegment& out) {
  MotionSamples& samples = bounds_.samples;
  check_states(out.curve, out.motion, inner, samples.batch);
  if (auto fault = sample_motion(out.curve, samples.batch, task.arm, task.placement, task.joints, false,
                                 samples.tool, samples.joint, samples.flange))
    throw MotionError(*fault);
}

void SpeedPlanner::check(const CertifiedTask& task, int inner, StopSegment& out) {
  MotionSamples& samples = bounds_.samples;
  out.sampled = ++sampled_;
  out.proved = false;
  out.ratios = {};
  if (!std::isfinite(out.motion.duration_s())) {  // beside a cusp the solver may lose all digits
    out.motion.t.back() = kUnlimited;
    out.factor = 1.0;
    return;
  }
  sample(task, inner, out);
  add_ratios(out.curve, samples.batch, samples.tool, samples.joint, task.groups, out.ratios);
  out.factor = std::isfinite(out.motion.duration_s()) ? out.ratios.time_factor() : kUnlimited;
}

/// The closed form on a line, where no joint binds. False: something else binds, or the speed limit varies.
bool SpeedPlanner::plan_straight(const CertifiedTask& task, StopSegment& out) {
  const double speed_limit = out.curve.speed_limit[0];
  for (const double c : out.curve.speed_limit)
    if (c != speed_limit) return false;
  const RateLimits& limit = task.limits.position;
  straight_motion(out.curve.s.back(), std::min(limit.rate, speed_limit), limit.acceleration, limit.jerk,
                  out.motion);
  check(task, kStraightInnerChecks, out);
  if (!(out.factor <= 1.0 + kClosedFormRounding)) return false;
  out.factor = 1.0;
  out.closed_form = true;
  return true;
}

bool SpeedPlanner::surely_slower(double max_s, const CertifiedTask& task, const StopSegment& out) {
  rows_of_ = 0;
  set_rows(task, out);
  const auto above = [&] {
    set_duration(out.curve, rows_, task.groups, 0, out.curve.cells(), bound_);
    return bound_.duration_s > max_s;
  };
  speed_bound(out.curve, rows_, task.groups, task.groups.count, bound_);
  if (above()) return true;
  tighten_bound(out.curve, rows_, task.groups, bound_);
  return above();
}

void SpeedPlanner::solve(const CertifiedTask& task, RowGroups& groups, int active, const Effort& effort,
                         StopSegment& out) {
  const bool starts = in_window_ && start_.b[0] > 0.0;
  ProfileOptions options = effort.solver;
  if (in_window_) options.gap = std::min(options.gap, kWindowGap);
  if (starts) options.start = &start_;
  speed_bound(out.curve, rows_, groups, active, bound_, {.first_b = starts ? start_.b[0] : 0.0});
  solve_profile(out.curve, rows_, groups, active, bound_.limit, bound_.b, options, solver_, profile_,
                task.in_descent ? &out.gradient : nullptr);
  cell_steps_ += std::uint64_t(profile_.iterations) * out.curve.cells();
  time_profile(out.curve, profile_, out.motion);
  check(task, effort.inner_checks, out);
  rows_of_ = out.sampled;
}

/// Solves with the limits of the joints that may bind; others are activated when they do, by the solver at
/// its knots or here between them. @param all every limit is active from the beginning. Returns true if the
/// solver activated one.
bool SpeedPlanner::solve_active(const CertifiedTask& task, const Effort& effort, bool all, StopSegment& out) {
  set_rows(task, out);
  ActiveGroups order = active_groups(rows_, task.groups);
  const int count = order.groups.count, active = all ? count : order.active;
  solve(task, order.groups, active, effort, out);
  const bool activated = profile_.groups > active;
  if (inactive_factor(out.ratios, task.groups, order.groups, profile_.groups) > kInactiveExcess)
    solve(task, order.groups, count, effort, out);
  return activated;
}

bool SpeedPlanner::attempt(const CertifiedTask& task, double max_s, const Finer& finer, StopSegment& out) {
  bool all = false;
  const MotionSamples& samples = bounds_.samples;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    StopSegment& trial = attempt == 0 ? out : trial_;
    trial.closed_form = false;
    if (attempt > 0) {
      if (attempt == 1) trial.curve = out.curve;
      finer(trial.curve);
      take_path_of(out, trial);
    }
    all = solve_active(task, effort(task, attempt), all, trial) || all;
    if (!std::isfinite(trial.motion.duration_s())) return false;
    const bool good = trial.factor < kAcceptedFactor + task.options.slack;
    if (!good) cell_factors(trial.curve, samples.batch, samples.tool, samples.joint, task.groups, excess_);
    const bool better = attempt > 0 && trial.duration_s() < out.duration_s();
    if (better) {
      const Curve divided = trial.curve;
      std::swap(trial, out);
      trial.curve = divided;
    }
    if (good || (std::isfinite(out.duration_s()) && out.motion.duration_s() > max_s)) return true;
    if (solved(out)) continue;
    if (out.duration_s() > kHopelessFactor * max_s) return true;
    if (attempt > 0 && !better) return false;
  }
  return false;
}

void SpeedPlanner::plan(const PathPart& part, const CellSizes& sizes, const MaxDuration& max,
                        const CertifiedTask& task, CurveWork& curve, StopSegment& out) {
  refine(sizes, curve, out.curve);
  set_speed_limit(part.points, part.speed_limit, curve, out.curve);
  if (out.curve.straight && part.yaw_rad.empty() && plan_straight(task, out)) return;
  const bool whole = out.curve.cells() <= kMaxWholeCells;
  if (!whole && plan_windows(sizes, max.planned_s, task, out)) return;
  if (whole && max.bound_s < kNoMaxDuration_s && surely_slower(max.bound_s, task, out)) return give_up(out);
  const Finer finer = [&](Curve& fine) {
    divide(sizes, curve, excess_, kCellFactor, fine);
    set_speed_limit(part.points, part.speed_limit, curve, fine);
  };
  if (!attempt(task, max.planned_s, finer, out)) fall_back(part, sizes, task, curve, out);
}

/// The solver's first guess, slowed down, always serves.
void SpeedPlanner::fall_back(const PathPart& part, const CellSizes& sizes, const CertifiedTask& task,
                             CurveWork& curve, StopSegment& out) {
  Effort none = effort(task, 0);
  none.solver.max_iterations = 0;
  StopSegment& guess = trial_;
  guess.closed_form = false;
  take_path_of(out, guess);
  refine(sizes, curve, guess.curve);
  set_speed_limit(part.points, part.speed_limit, curve, guess.curve);
  set_rows(task, guess);
  RowGroups groups = task.groups;
  solve(task, groups, groups.count, none, guess);
  if (!(out.duration_s() <= guess.duration_s())) std::swap(guess, out);
  if (!std::isfinite(out.duration_s())) out.deviation_mm = kUnlimited;
}

void SpeedPlanner::set_lower_bound(const CertifiedTask& task, StopSegment& out) {
  if (out.closed_form && !task.options.bound_without_jerk) {
    out.bound_s = out.motion.duration_s();
    return;
  }
  if (rows_of_ != out.sampled) {
    set_rows(task, out);
    speed_bound(out.curve, rows_, task.groups, task.groups.count, bound_);
  }
  if (!task.options.bound_without_jerk) tighten_bound(out.curve, rows_, task.groups, bound_);
  set_duration(out.curve, rows_, task.groups, 0, out.curve.cells(), bound_);
  out.bound_s = bound_.duration_s;
}

void SpeedPlanner::prove(const CertifiedTask& task, StopSegment& out) {
  if (out.proved || !std::isfinite(out.duration_s())) return;
  const bool fast = task.options.method != Method::kOptimal && !moves_within_tolerance(task.options);
  const double sharpness = fast ? kFastSharpness : kFineSharpness;
  if (out.curve.cells() > kMaxWholeCells) {
    prove_windows(task, sharpness, out);
  } else {
    if (task.options.lower_bound) set_lower_bound(task, out);  // while rows_ may be those of `out`
    if (sampled_ != out.sampled) {
      ++sampled_;
      sample(task, 1, out);
    }
    const BoundedMotion bounded{out.curve, out.motion, task.arm, task.placement, task.groups, task.joints};
    if (auto fault = bound_motion(bounded, sharpness, bounds_, out.ratios)) throw MotionError(*fault);
  }
  out.proved = true;
  out.factor = out.ratios.time_factor();
  if (!std::isfinite(out.factor)) throw MotionError(Fault(Reason::kNoSolution));
}

}  // namespace firn::motion
