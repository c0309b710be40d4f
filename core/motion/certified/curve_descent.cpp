#include "core/motion/certified/curve_descent.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::motion {
namespace {

/// Weights of |change of r'''|^2 of a step: the curvature of T that makes the gradient G of T that of w
/// |r'''|^2 / 2, G / |r'''|, and so that of slow places as well v^5 / (3 jerk^2), which is the same where
/// jerk alone decides: v = (jerk / |r'''|)^(1/3), T = integral of ds / v. Beside a rest the speed is that
/// of its first maximum: a curve that bends freely at the lowest speeds costs those after them.
void set_weights(const StopSegment& planned, double share, const RateLimits& limit,
                 std::vector<double>& weight) {
  const Curve& c = planned.curve;
  const std::vector<double>& v = planned.motion.v;
  const TimeGradient& g = planned.gradient;
  const double fastest = *std::max_element(v.begin(), v.end()), square = fastest * fastest;
  const double scale = square * square * fastest / (3.0 * limit.jerk * limit.jerk);
  weight.assign(v.size(), 0.0);
  for (std::size_t i = 0; i < c.cells(); ++i) {
    const double h = c.s[i + 1] - c.s[i], faster = std::max(v[i], v[i + 1]);
    const double gx = g.x[2][2 * i] + g.x[2][2 * i + 1], gy = g.y[2][2 * i] + g.y[2][2 * i + 1];
    const double x = c.xx[i + 1] - c.xx[i], y = c.yy[i + 1] - c.yy[i];
    const double third =
        std::max(std::sqrt(x * x + y * y), kMinThirdShare * h * limit.jerk / (faster * faster * faster));
    const double own = std::sqrt(gx * gx + gy * gy) / third;
    weight[i] = std::max(weight[i], own);
    weight[i + 1] = std::max(weight[i + 1], own);
  }
  std::size_t rises = 0, falls = v.size() - 1;
  while (v[rises + 1] > v[rises]) ++rises;
  while (v[falls - 1] > v[falls]) --falls;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double u = v[std::clamp(i, rises, falls)] / fastest, u2 = u * u;
    weight[i] = share * (scale * (kMinWeight + u2 * u2 * u) + weight[i]);
  }
}

/// Duration by which descent judges a curve: without the slowing down for limits exceeded between the
/// profile's knots, as long as it is slight. That depends on where they fall, and finer cells take it away.
double judged_s(const StopSegment& planned) {
  return std::max(1.0, planned.factor - kForgivenFactor) * planned.motion.duration_s();
}

class CurveDescent {
 public:
  CurveDescent(const PathPart& part, SegmentCurve& curve, SpeedPlanner& speed, DescentWork& work,
               StopSegment& out)
      : part_{part.points, part.speed_limit},
        curve_(curve),
        speed_(speed),
        work_(work),
        trial_(work.trial),
        out_(out) {
    curve_.follow(part);
    trial_.first = out.first;
    trial_.last = out.last;
  }

  /// Plans along fits of several radii. Descent begins at the fastest one and at another, the widest or else
  /// the fastest of the rest, both in a tube as wide as the tolerance allows; the faster one after some
  /// rounds is kept. Returns whether it can be improved.
  bool start(const CertifiedTask& task) {
    const PlanOptions& options = task.options;
    const double tolerance = allowed_deviation_mm(options);
    samples_ = !(options.tolerance_mm > 0.0);
    const double widest = std::max(fit_radius_mm(options), kHeldRadiusShare * hold_mm(options));
    double best_s = try_radius(widest, task);
    if (curve_.tube.lines && (!holds(out_, options) || !curve_.tube.converged)) {
      hold_lines_ = false;  // some chord is no line after all
      first_ = true;
      best_s = try_radius(widest, task);
    }
    if (!(out_.deviation_mm <= tolerance) || out_.curve.straight || !solved(out_) || !holds(out_, options))
      return false;
    double best = widest, second = 0.0, second_s = kUnlimited;
    for (double r = kMinFitRadius_mm; !samples_ && r < kMaxFitRadiusShare * tolerance; r *= kFitRadiusRatio) {
      const double r_s = try_radius(r, task);
      if (r_s < best_s) {
        second = std::exchange(best, r);
        second_s = std::exchange(best_s, r_s);
      } else if (r_s < second_s) {
        second = r;
        second_s = r_s;
      }
    }
    fit_inside(best, task);
    begin(best, widest);
    if (second == 0.0) return true;
    descend(kTrialRounds, task);
    compare_with(best == widest ? second : widest, widest, task);
    return true;
  }

  /// Plans the present curve as `task` demands.
  void plan_again(const CertifiedTask& task) {
    base_curve(curve_.tube, curve_.curve.coarse);
    plan(kUnlimited, task, out_);
  }

  /// Plans the present curve on finer cells, where that is faster: on those of the descent its time depends
  /// by up to half a percent on where they fall.
  void refine(const CertifiedTask& task) {
    base_curve(curve_.tube, curve_.curve.coarse);
    CellSizes sizes = SpeedPlanner::cell_sizes(part_, task);
    sizes.split *= kLastSplit;
    measure(task);
    speed_.plan(part_, sizes, {}, task, curve_.curve, trial_);
    if (trial_.duration_s() < out_.duration_s()) std::swap(trial_, out_);
  }

  void descend(int rounds, const CertifiedTask& task) {
    const PlanOptions& options = task.options;
    int failures = 0;
    for (int round = 0; round < rounds && failures < kMaxFailures; ++round) {
      if (out_.gradient.x[0].size() != 2 * out_.curve.cells()) return;
      set_weights(out_, weight_, task.limits.position, work_.weight);
      const TimeGradient& g = out_.gradient;
      step_tube(out_.curve, {{g.x[0], g.x[1], g.x[2]}, {g.y[0], g.y[1], g.y[2]}}, work_.weight,
                judged_s(out_), curve_.tube, curve_.curve.coarse);
      measure(task);
      const double over = trial_.deviation_mm - allowed_deviation_mm(options);
      if (!holds(trial_, options)) {
        widen_tube(hold_mm(options) - trial_.points_off_mm - kStepMargin * hold_mm(options), curve_.tube);
        ++failures;
        continue;
      }
      if (over > 0.0) {  // between two places: the tube is narrowed there for the next try
        narrow(task);
        ++failures;
        continue;
      }
      plan(out_.duration_s(), task, trial_);
      const bool faster = judged_s(trial_) < judged_s(out_);
      weight_ *= faster ? kWeightDecay : kWeightGrowth;
      failures = faster && judged_s(trial_) < (1.0 - kMinGain) * judged_s(out_) ? 0 : failures + 1;
      if (!faster) continue;
      std::swap(trial_, out_);
      curve_.tube.base = curve_.tube.control;
    }
  }

 private:
  /// Descends from the fit of another radius, too, and keeps the faster curve.
  void compare_with(double radius, double widest, const CertifiedTask& task) {
    TubeWork tube = curve_.tube;
    const double weight = weight_;
    StopSegment other;
    std::swap(out_, other);
    out_.first = other.first;
    out_.last = other.last;
    fit_inside(radius, task);
    plan(kUnlimited, task, trial_);
    std::swap(trial_, out_);
    begin(radius, widest);
    descend(kTrialRounds, task);
    if (judged_s(out_) <= judged_s(other)) return;
    std::swap(out_, other);
    std::swap(curve_.tube, tube);
    weight_ = weight;
  }

  void fit(double radius, const CertifiedTask& task) {
    const CellSizes sizes = SpeedPlanner::cell_sizes(part_, task);
    curve_.fit(part_.points, {.radius_mm = radius,
                              .between_mm = samples_ ? kSagittaMm : radius,
                              .max_between_mm = max_between_mm(task.options),
                              .largest_mm = sizes.largest_mm,
                              .tolerance_mm = allowed_deviation_mm(task.options),
                              .hold_lines = hold_lines_ && hold_mm(task.options) > 0.0});
  }

  /// The same inside the tolerance, if a tube that is narrower in places brings it there.
  void fit_inside(double radius, const CertifiedTask& task) {
    fit(radius, task);
    for (int tries = 0;; ++tries) {
      measure(task);
      if (trial_.deviation_mm <= allowed_deviation_mm(task.options) || tries == kMaxNarrowings ||
          curve_.curve.coarse.straight)
        return;
      narrow(task);
      refit_tube(curve_.tube, curve_.curve.coarse);
    }
  }

  /// Descent will begin at the present fit of this radius, which `out_` is planned along, in a tube as wide
  /// as the tolerance: it is narrowed where a step leaves that.
  void begin(double radius, double widest) {
    if (!samples_) widen_tube(widest - kTubePlaceRadius * radius, curve_.tube);
    curve_.tube.base = curve_.tube.control;
    weight_ = kFirstWeight;
  }

  /// Sets the trial's distances of the present curve from the path and from held points.
  void measure(const CertifiedTask& task) { curve_.measure(part_.points, task.options, trial_); }

  /// Narrows the tube where the present curve is outside of the tolerance.
  void narrow(const CertifiedTask& task) {
    const double allowed = allowed_deviation_mm(task.options);
    const GivenReference& path = curve_.followed();
    find_stretches_beyond(curve_.curve.coarse, path.points, std::max(0.0, allowed - path.sagitta_mm),
                          work_.beyond);
    narrow_tube(work_.beyond, kStepMargin * allowed, curve_.tube);
  }

  void plan(double max_s, const CertifiedTask& task, StopSegment& segment) {
    speed_.plan(part_, SpeedPlanner::cell_sizes(part_, task), {.planned_s = max_s}, task, curve_.curve,
                segment);
  }

  /// Plans along the fit of this radius, which becomes `out_` where it is faster, or the first. Returns its
  /// duration, unlimited where it is outside of the tolerance.
  double try_radius(double radius, const CertifiedTask& task) {
    fit_inside(radius, task);
    const bool first = std::exchange(first_, false);
    if (!first && trial_.deviation_mm > allowed_deviation_mm(task.options)) return kUnlimited;
    if (!holds(trial_, task.options)) {
      if (first) {
        give_up(trial_);
        std::swap(trial_, out_);
      }
      return kUnlimited;
    }
    plan(first ? kUnlimited : out_.duration_s(), task, trial_);
    const double duration_s = trial_.duration_s();
    if (first || duration_s < out_.duration_s()) std::swap(trial_, out_);
    return duration_s;
  }

  PathPart part_;  ///< without yaw, which a moved curve has not
  SegmentCurve& curve_;
  SpeedPlanner& speed_;
  DescentWork& work_;
  StopSegment &trial_, &out_;
  bool first_ = true, samples_ = false, hold_lines_ = true;
  double weight_ = kFirstWeight;
};

}  // namespace

void plan_by_descent(const PathPart& part, const CertifiedTask& task, SegmentCurve& curve,
                     SpeedPlanner& speed, DescentWork& work, StopSegment& out) {
  CertifiedTask own = task;
  own.in_descent = true;
  // the slow tier does most of its descent on the fast tier's cells
  PlanOptions options = task.options;
  options.method = Method::kCertified;
  const CertifiedTask fast{task.arm, task.limits, options, task.placement, task.joints, task.groups, true};
  const bool slow = task.options.method == Method::kOptimal;
  CurveDescent descent(part, curve, speed, work, out);
  const bool moves = descent.start(fast);
  if (moves) descent.descend(kDescentRounds, fast);
  if (!slow) {
    if (moves) descent.refine(fast);
  } else if (moves) {
    descent.plan_again(own);
    descent.descend(kLastRounds, own);
  } else {  // a straight line, or no curve within the tolerance
    CurveDescent(part, curve, speed, work, out).start(own);
  }
}

}  // namespace firn::motion
