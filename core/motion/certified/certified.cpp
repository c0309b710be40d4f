#include "core/motion/certified/certified.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/curve/deviation.h"
#include "core/motion/curve/frechet.h"

namespace firn::motion {
namespace {

/// Samples of letters are some micrometres apart, their speed changes over tens of micrometres.
constexpr double kLeastCellMm = 5e-4;
/// Cells of the fast tier are divided so often where a tolerance is used without slack.
constexpr double kWithinSplit = 2.0;
constexpr double kWithinGap = 0.003;    ///< where a tolerance is used without slack
constexpr double kDescentGap = 0.0015;  ///< where the curve is moved

struct Effort {
  CellSizes sizes;
  ProfileOptions solver;
  int inner_checks;
};

/// How hard the profile is worked on. When the check shows that a limit is exceeded between the places where
/// the solver looked, or the solver did not converge, the next attempt is finer. Times that descent compares
/// are all as exact.
Effort effort(const CertifiedTask& task, const CertifiedWork& work, int attempt) {
  Effort e{CellSizes{}, ProfileOptions{}, 1};
  const PlanOptions& options = task.options;
  const bool slow = options.method == Method::kOptimal;
  e.solver.from_both_ends = options.curve_rule == CurveRule::kFitted;
  if (slow) {
    e.sizes.rest_growth = 1.04;
    e.sizes.rest_mm = 0.01;
    e.sizes.split = 8.0;
    e.sizes.least_mm = kLeastCellMm;
    e.solver.gap = 1e-4;
    e.solver.most_iterations = 80;
    e.inner_checks = 2;
  } else if (work.descends || within_tolerance(options)) {
    e.sizes.split = kWithinSplit;
    e.solver.gap = work.descends ? kDescentGap : kWithinGap;
  }
  if (attempt > 0) {
    e.solver.most_iterations = 80;
    if (slow || !work.descends) e.solver.gap *= 0.25;
  }
  return e;
}

constexpr double kSmoothShare = 0.9;  ///< of the tolerance, for moving the points of dense runs
constexpr double kSlightly =
    0.6;  ///< a curve that leaves the tolerance by less is first tried with less of it
constexpr double kLessSagitta = 0.2;  ///< where interpolated vertices of uneven chords leave the tolerance
constexpr double kLeastShare = 0.1, kMostShare = 0.9;  ///< of the tolerance, from one try to the next
constexpr double kMostFittedShare = 0.98;
constexpr int kShapes = 10;        ///< tries to bring the curve inside the tolerance
constexpr int kHoldTries = 6;      ///< and within the points' rounding
constexpr double kHoldAim = 0.95;  ///< of that
constexpr double kLeastRampMm = 0.01;
constexpr int kAttempts = 4;
constexpr double kHopeless = 1.5;      ///< times too slow without a solution: finer cells will not help
constexpr double kCellFactor = 1.002;  ///< cells that need more are divided for the next attempt
constexpr double kGoodFactor = 1.006;  ///< slowing down by less than this is cheaper than another attempt

/// The motion of `out` at both ends and inside of every piece, into work.bounds.samples.
void sample(const CertifiedTask& task, int inner, CertifiedWork& work, const StopSegment& out) {
  MotionSamples& samples = work.bounds.samples;
  check_states(out.curve, out.motion, inner, samples.batch);
  if (auto fault = sample_motion(out.curve, samples.batch, task.arm, task.placement, task.joints, false,
                                 samples.tool, samples.joint, samples.flange))
    throw MotionError(*fault);
}

/// Ratios of the motion in `out` there.
void check(const CertifiedTask& task, int inner, CertifiedWork& work, StopSegment& out) {
  MotionSamples& samples = work.bounds.samples;
  out.sampled = ++work.sampled;
  out.proved = false;
  out.ratios = {};
  if (!std::isfinite(out.motion.duration_s())) {  // beside a cusp the solver may lose all digits
    out.motion.t.back() = kUnlimited;
    out.factor = 1.0;
    return;
  }
  sample(task, inner, work, out);
  add_ratios(out.curve, samples.batch, samples.tool, samples.joint, task.groups, out.ratios);
  out.factor = std::isfinite(out.motion.duration_s()) ? out.ratios.time_factor() : kUnlimited;
}

/// The closed form on a line, where no joint binds. False: something else binds, or the speed limit varies.
bool plan_straight(const CertifiedTask& task, CertifiedWork& work, StopSegment& out) {
  const double speed_limit = out.curve.speed_limit[0];
  for (const double c : out.curve.speed_limit)
    if (c != speed_limit) return false;
  const RateLimits& limit = task.limits.position;
  straight_motion(out.curve.s.back(), std::min(limit.rate, speed_limit), limit.acceleration, limit.jerk,
                  out.motion);
  check(task, 3, work, out);
  if (!(out.factor <= 1.0 + 1e-9)) return false;
  out.factor = 1.0;
  out.closed_form = true;
  return true;
}

/// The tool's motion, and the joints that may come near a limit while the tool keeps its own: joints whose
/// q' times the tool's largest rate, acceleration and jerk stays well below theirs come last.
struct BindingGroups {
  RowGroups groups;
  int active = 1;  ///< the first so many
};
BindingGroups binding_groups(const MotionRows& rows, const RowGroups& all) {
  constexpr double kRateShare = 0.97, kShare = 0.8;
  const RateLimits& tool = all.group[0].limit;
  BindingGroups order{all, 1};
  for (int g = 1; g < all.count; ++g) {
    const RateLimits& limit = all.group[g].limit;
    const double least =
        std::min({kRateShare * limit.rate / tool.rate, kShare * limit.acceleration / tool.acceleration,
                  kShare * limit.jerk / tool.jerk});
    const std::vector<double>& slope = rows.of[all.group[g].first][0];
    double most = 0.0;
    for (const double d1 : slope) most = std::max(most, std::abs(d1));
    if (most > least) std::swap(order.groups.group[order.active++], order.groups.group[g]);
  }
  return order;
}

void set_rows(const CertifiedTask& task, CertifiedWork& work, const StopSegment& out) {
  if (auto fault = compute_rows(out.curve, task.arm, task.placement, task.joints, work.rows))
    throw MotionError(*fault);
}

void bound(const CertifiedTask& task, const RowGroups& groups, int active, CertifiedWork& work,
           StopSegment& out) {
  const bool fitted = task.options.curve_rule == CurveRule::kFitted;
  speed_bound(out.curve, work.rows, groups, active, !fitted, work.bound);
  if (fitted) return;  // prove() will
  set_duration(out.curve, work.rows, groups, work.bound);
  out.bound_s = work.bound.duration_s;
}

void solve(const CertifiedTask& task, RowGroups& groups, int active, const Effort& effort,
           CertifiedWork& work, StopSegment& out) {
  bound(task, groups, active, work, out);
  solve_profile(out.curve, work.rows, groups, active, work.bound.limit, work.bound.b, effort.solver,
                work.solver, work.profile, work.descends ? &out.gradient : nullptr);
  time_profile(out.curve, work.profile, out.motion);
  check(task, effort.inner_checks, work, out);
  work.rows_of = out.sampled;
}

/// Largest factor by which time must be stretched for the groups that did not take part.
double left_out_factor(const RatioTable& ratios, const RowGroups& all, const RowGroups& order,
                       int took_part) {
  double factor = 0.0;
  for (int g = 0; g < all.count; ++g)
    for (int k = took_part; k < order.count; ++k)
      if (order.group[k].first == all.group[g].first) factor = std::max(factor, factor_of(ratios.ratio[g]));
  return factor;
}

/// Joints that seem not to bind join when they do. Returns whether one did.
bool solve(const CertifiedTask& task, const Effort& effort, bool all, CertifiedWork& work, StopSegment& out) {
  constexpr double kSlight = 1.0005;
  set_rows(task, work, out);
  BindingGroups order = binding_groups(work.rows, task.groups);
  const int count = order.groups.count, active = all ? count : order.active;
  solve(task, order.groups, active, effort, work, out);
  const bool activated = work.profile.groups > active;
  if (left_out_factor(out.ratios, task.groups, order.groups, work.profile.groups) >
      kSlight)  // between the knots
    solve(task, order.groups, count, effort, work, out);
  else if (activated && task.options.lower_bound && task.options.curve_rule == CurveRule::kRamped)
    bound(task, order.groups, count, work, out);
  return activated;
}

/// Speed along the segment from points[i] at which the tool turns as fast as it may.
double turning_speed(std::span<const Point2> points, std::span<const double> yaw_rad, std::size_t i,
                     const MotionLimits& limits) {
  if (yaw_rad.empty()) return kUnlimited;
  const double dx = points[i + 1].x_mm - points[i].x_mm, dy = points[i + 1].y_mm - points[i].y_mm;
  const double turn = std::abs(yaw_rad[i + 1] - yaw_rad[i]);
  return turn > 0.0 ? limits.orientation.rate * std::sqrt(dx * dx + dy * dy) / turn : kUnlimited;
}

/// The first cell at rest, shorter where a low speed is reached within it: v^(3/2) / j^(1/2) from rest.
double rest_cell(double size_mm, double speed_mm_s, const RateLimits& limit) {
  constexpr double kLeastMm = 1e-4;
  const double v = std::min(limit.rate, speed_mm_s);
  return std::min(size_mm, std::max(kLeastMm, 0.5 * v * std::sqrt(v / limit.jerk)));
}

}  // namespace

CellSizes cell_sizes(std::span<const Point2> points, std::span<const double> speed_limit,
                     std::span<const double> yaw_rad, const CertifiedTask& task, const CertifiedWork& work) {
  CellSizes sizes = effort(task, work, 0).sizes;
  const double low_mm_s =
      std::max(std::min(speed_limit.front(), turning_speed(points, yaw_rad, 0, task.limits)),
               std::min(speed_limit.back(), turning_speed(points, yaw_rad, points.size() - 2, task.limits)));
  sizes.rest_mm = rest_cell(sizes.rest_mm, low_mm_s, task.limits.position);
  return sizes;
}

void plan_curve(std::span<const Point2> points, std::span<const double> speed_limit,
                std::span<const double> yaw_rad, const CellSizes& sizes, double most_s,
                const CertifiedTask& task, CertifiedWork& work, StopSegment& out) {
  bool all = false;
  const MotionSamples& samples = work.bounds.samples;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Effort effort = motion::effort(task, work, attempt);
    StopSegment& trial = attempt == 0 ? out : work.trial;
    trial.closed_form = false;
    if (attempt == 0) {
      refine(sizes, work.curve, trial.curve);
    } else {
      if (attempt == 1) trial.curve = out.curve;
      divide(sizes, work.curve, work.excess, kCellFactor, trial.curve);
    }
    set_speed_limit(points, speed_limit, work.curve, trial.curve);
    trial.first = out.first;
    trial.last = out.last;
    trial.deviation_mm = out.deviation_mm;
    trial.points_off_mm = out.points_off_mm;
    if (attempt == 0 && trial.curve.straight && yaw_rad.empty() && plan_straight(task, work, trial)) {
      if (!task.options.lower_bound || task.options.curve_rule == CurveRule::kFitted) return;
      set_rows(task, work, trial);
      bound(task, task.groups, task.groups.count, work, trial);
      return;
    }
    all = solve(task, effort, all, work, trial) || all;
    if (!std::isfinite(trial.motion.duration_s())) break;
    const bool good = trial.factor < kGoodFactor + task.options.slack;
    if (!good)
      cell_factors(trial.curve, samples.batch, samples.tool, samples.joint, task.groups, work.excess);
    const bool better = attempt > 0 && trial.duration_s() < out.duration_s();
    if (better) {
      const Curve divided = trial.curve;
      std::swap(trial, out);
      trial.curve = divided;
    }
    if (good || (std::isfinite(out.duration_s()) && out.motion.duration_s() > most_s)) return;
    if (task.options.curve_rule == CurveRule::kRamped || solved(out)) continue;
    if (out.duration_s() > kHopeless * most_s) return;
    if (attempt > 0 && !better) break;
  }
  // the solver's first guess, slowed down, always serves
  Effort none = effort(task, work, 0);
  none.solver.most_iterations = 0;
  StopSegment& guess = work.trial;
  guess.closed_form = false;
  guess.first = out.first;
  guess.last = out.last;
  guess.deviation_mm = out.deviation_mm;
  guess.points_off_mm = out.points_off_mm;
  refine(sizes, work.curve, guess.curve);
  set_speed_limit(points, speed_limit, work.curve, guess.curve);
  set_rows(task, work, guess);
  RowGroups groups = task.groups;
  solve(task, groups, groups.count, none, work, guess);
  if (!(out.duration_s() <= guess.duration_s())) std::swap(guess, out);
  if (!std::isfinite(out.duration_s())) out.deviation_mm = kUnlimited;
}

void plan_segment(std::span<const Point2> points, std::span<const double> speed_limit,
                  std::span<const double> yaw_rad, std::span<const GivenCurve> given, Shape shape,
                  double most_s, const CertifiedTask& task, CertifiedWork& work, StopSegment& out) {
  const bool fitted = shape == Shape::kFitted;
  const CellSizes sizes = cell_sizes(points, speed_limit, yaw_rad, task, work);
  CurveOptions spec{task.options.curvature_ramp_mm,
                    shape == Shape::kPlain ? 0.0 : task.options.tolerance_mm,
                    0.0,
                    sizes,
                    task.options.curve_rule == CurveRule::kFitted,
                    yaw_rad,
                    given,
                    hold_mm(task.options)};
  const GivenReference reference = sample_given(points, given, work.reference);
  bool hold_lines = fitted && spec.hold_mm > 0.0;
  const auto form = [&] {
    if (fitted) {
      const double radius = spec.tolerance_mm > 0.0 ? spec.tolerance_mm
                            : spec.hold_mm > 0.0    ? kHoldRadius * spec.hold_mm
                                                    : fit_radius_mm(task.options);
      fit_tube(points,
               {.radius_mm = radius,
                .between_mm = std::max(radius, spec.tolerance_mm > 0.0 ? 0.0 : kSagittaMm),
                .most_between_mm = most_between_mm(task.options),
                .largest_mm = sizes.largest_mm,
                .hold_lines = hold_lines},
               work.tube, work.curve.coarse);
      work.curve.offset.assign({0.0, work.curve.coarse.s.back()});
      return;
    }
    build_curve(points, spec, work.curve);
    if (shape != Shape::kSmoothed) return;
    smooth_dense(points, work.curve.pieces, kDenseWidths * spec.ramp_mm, kSmoothShare * spec.tolerance_mm,
                 work.smoothing, work.smoothed);
    build_curve(work.smoothed, spec, work.curve);
  };
  form();
  int held_tries = 0;
  CurveOptions nearest = spec;
  double nearest_mm = kUnlimited;
  const PlanOptions& options = task.options;
  const bool unbound = options.tolerance_mm > 0.0 ? shape == Shape::kPlain : fitted;
  const double allowed_mm = unbound                      ? kUnlimited
                            : options.tolerance_mm > 0.0 ? options.tolerance_mm
                                                         : farthest_mm(options);
  for (int tries = 0;; ++tries) {
    const Curve& curve = work.curve.coarse;
    out.deviation_mm = options.curve_rule == CurveRule::kFitted
                           ? frechet_bound(curve, reference.points) + reference.sagitta_mm
                       : curve.straight ? 0.0
                                        : deviation(curve, points, work.length);
    out.points_off_mm = spec.hold_mm > 0.0 ? farthest_point_mm(curve, points, hold_mm(options)) : 0.0;
    const bool lines = hold_lines && work.tube.lines;
    if ((!holds(out, options) || (lines && !work.tube.converged)) && tries < kHoldTries) {
      // a tube too narrow: some chord is no line after all
      hold_lines = false;
      if (!lines)
        spec.hold_mm *= std::clamp(kHoldAim * hold_mm(options) / out.points_off_mm, kLeastShare, kMostShare);
      form();
      continue;
    }
    if (out.deviation_mm <= allowed_mm) break;
    if (out.deviation_mm < nearest_mm) {
      nearest = spec;
      nearest_mm = out.deviation_mm;
    }
    if (tries == kShapes) {
      spec = nearest;
      form();
      out.deviation_mm = nearest_mm;
      break;
    }
    const double share =
        std::clamp(0.98 * allowed_mm / out.deviation_mm, kLeastShare, fitted ? kMostFittedShare : kMostShare);
    if (fitted || (tries == 0 && share > kSlightly && spec.tolerance_mm > 0.0)) {
      spec.tolerance_mm *= share;
    } else if (spec.held_sagitta_mm == 0.0) {
      spec.tolerance_mm = allowed_mm;
      spec.held_sagitta_mm = std::min(kSagittaMm, spec.tolerance_mm);
    } else {
      double& less = held_tries == 0 ? spec.held_sagitta_mm : spec.tolerance_mm;
      less *= held_tries == 0 ? kLessSagitta : share;
      ++held_tries;
      if (held_tries > 2)
        spec.ramp_mm = std::max(0.6 * spec.ramp_mm, kLeastRampMm);  // w itself is too long for this curve
    }
    form();
  }
  if (fitted && !holds(out, options)) {  // a tube too narrow for its turns; another shape holds
    give_up(out);
    return;
  }
  plan_curve(points, speed_limit, yaw_rad, sizes, most_s, task, work, out);
}

void prove(const CertifiedTask& task, CertifiedWork& work, StopSegment& out) {
  constexpr double kFastSharpness = 3e-4, kSlowSharpness = 3e-5;  ///< of the bounds, as factors of time
  if (out.proved || !std::isfinite(out.duration_s())) return;
  if (task.options.lower_bound && out.closed_form && !task.options.bound_without_jerk) {
    out.bound_s = out.motion.duration_s();
  } else if (task.options.lower_bound) {  // while work.rows may be those of `out`
    if (work.rows_of != out.sampled) {
      set_rows(task, work, out);
      bound(task, task.groups, task.groups.count, work, out);
    }
    if (!task.options.bound_without_jerk) tighten_bound(out.curve, work.rows, task.groups, work.bound);
    set_duration(out.curve, work.rows, task.groups, work.bound);
    out.bound_s = work.bound.duration_s;
  }
  if (work.sampled != out.sampled) {
    ++work.sampled;
    sample(task, 1, work, out);
  }
  const BoundedMotion bounded{out.curve, out.motion, task.arm, task.placement, task.groups, task.joints};
  const bool fast = task.options.method != Method::kOptimal && !within_tolerance(task.options);
  const double sharpness = fast ? kFastSharpness : kSlowSharpness;
  if (auto fault = bound_motion(bounded, sharpness, work.bounds, out.ratios)) throw MotionError(*fault);
  out.proved = true;
  out.factor = out.ratios.time_factor();
  if (!std::isfinite(out.factor)) throw MotionError(Fault(Reason::kNoSolution));
}

}  // namespace firn::motion
