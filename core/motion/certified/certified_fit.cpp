// The curve inside the tolerance: fits of several radii are starts, then descent of the time. The multipliers
// of the speed profile's limits are the gradient of the minimum time with regard to the curve.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/certified/certified.h"
#include "core/motion/curve/frechet.h"

namespace firn::motion {
namespace {

constexpr double kLeastRadius_mm = 0.003, kRadiusRatio = 3.0;  ///< of the starts
constexpr double kMostRadiusShare = 0.7;                       ///< of the tolerance
constexpr int kShrinks = 10;                    ///< tries to bring a start inside the tolerance
constexpr int kTrialRounds = 24, kRounds = 96;  ///< of descent: from each of two starts, of the better
constexpr int kLastRounds = 8;                  ///< of descent on the slow tier's cells
constexpr int kMostFailures = 6;                ///< one after another
constexpr double kGain = 3e-5;                  ///< of a round that is worth another
constexpr double kBelow = 0.01;     ///< of the tolerance, by which a step that left it is to stay below it
constexpr double kLastSplit = 2.0;  ///< of cells, when the curve is found
constexpr double kFirstWeight = 2.0, kHeavier = 2.0, kLighter = 0.8;

/// Largest deviation of the curve from the polygon. Without a tolerance the points bind before that.
double allowed_mm(const PlanOptions& options) {
  return options.tolerance_mm > 0.0 ? options.tolerance_mm : farthest_mm(options);
}

/// Weights of |change of r'''|^2 of a step: the curvature of T that makes the gradient G of T that of w
/// |r'''|^2 / 2, G / |r'''|, and so that of slow places as well v^5 / (3 jerk^2), which is the same where
/// jerk alone decides: v = (jerk / |r'''|)^(1/3), T = integral of ds / v. Beside a rest the speed is that
/// of its first maximum: a curve that bends freely at the lowest speeds costs those after them.
void set_weights(const StopSegment& planned, double share, const RateLimits& limit,
                 std::vector<double>& weight) {
  constexpr double kLeast = 1e-5, kLeastJerk = 0.6;
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
        std::max(std::sqrt(x * x + y * y), kLeastJerk * h * limit.jerk / (faster * faster * faster));
    const double own = std::sqrt(gx * gx + gy * gy) / third;
    weight[i] = std::max(weight[i], own);
    weight[i + 1] = std::max(weight[i + 1], own);
  }
  std::size_t rises = 0, falls = v.size() - 1;
  while (v[rises + 1] > v[rises]) ++rises;
  while (v[falls - 1] > v[falls]) --falls;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double u = v[std::clamp(i, rises, falls)] / fastest, u2 = u * u;
    weight[i] = share * (scale * (kLeast + u2 * u2 * u) + weight[i]);
  }
}

/// Duration by which descent judges a curve: without the slowing down for limits exceeded between the
/// profile's knots, as long as it is slight. That depends on where they fall, and finer cells take it away.
double judged_s(const StopSegment& planned) {
  constexpr double kSlight = 0.006;
  return std::max(1.0, planned.factor - kSlight) * planned.motion.duration_s();
}

class FitPlanner {
 public:
  FitPlanner(std::span<const Point2> points, std::span<const double> speed_limit,
             std::span<const GivenCurve> given, CertifiedWork& work, StopSegment& out)
      : points_(points),
        reference_(sample_given(points, given, work.reference)),
        speed_limit_(speed_limit),
        work_(work),
        trial_(work.shape_trial),
        out_(out) {
    trial_.first = out.first;
    trial_.last = out.last;
    work.descends = true;
  }
  ~FitPlanner() { work_.descends = false; }
  FitPlanner(const FitPlanner&) = delete;

  /// Plans along fits of several radii. Descent begins at the fastest one and at another, the widest or else
  /// the fastest of the rest, both in a tube as wide as the tolerance allows; the faster one after some
  /// rounds is kept. Returns whether it can be improved.
  bool start(const CertifiedTask& task) {
    const double tolerance = allowed_mm(task.options);
    samples_ = !(task.options.tolerance_mm > 0.0);
    const double widest = std::max(fit_radius_mm(task.options), kHoldRadius * hold_mm(task.options));
    double best_s = try_radius(widest, task);
    if (work_.tube.lines && (!holds(out_, task.options) || !work_.tube.converged)) {
      hold_lines_ = false;  // some chord is no line after all
      first_ = true;
      best_s = try_radius(widest, task);
    }
    if (!(out_.deviation_mm <= tolerance) || out_.curve.straight || !solved(out_) ||
        !holds(out_, task.options))
      return false;
    double best = widest, second = 0.0, second_s = kUnlimited;
    for (double r = kLeastRadius_mm; !samples_ && r < kMostRadiusShare * tolerance; r *= kRadiusRatio) {
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
    TubeWork tube = work_.tube;
    const double weight = weight_;
    StopSegment other;
    std::swap(out_, other);
    out_.first = other.first;
    out_.last = other.last;
    second = best == widest ? second : widest;
    fit_inside(second, task);
    plan(kUnlimited, task, trial_);
    std::swap(trial_, out_);
    begin(second, widest);
    descend(kTrialRounds, task);
    if (judged_s(out_) <= judged_s(other)) return true;
    std::swap(out_, other);
    std::swap(work_.tube, tube);
    weight_ = weight;
    return true;
  }

  /// Plans the present curve as `task` demands.
  void plan_again(const CertifiedTask& task) {
    base_curve(work_.tube, work_.curve.coarse);
    plan(kUnlimited, task, out_);
  }

  /// Plans the present curve on finer cells, where that is faster: on those of the descent its time depends
  /// by up to half a percent on where they fall.
  void refine(const CertifiedTask& task) {
    base_curve(work_.tube, work_.curve.coarse);
    CellSizes sizes = cell_sizes(points_, speed_limit_, {}, task, work_);
    sizes.split *= kLastSplit;
    measure(task);
    plan_curve(points_, speed_limit_, {}, sizes, kUnlimited, task, work_, trial_);
    if (trial_.duration_s() < out_.duration_s()) std::swap(trial_, out_);
  }

  void descend(int rounds, const CertifiedTask& task) {
    int failures = 0;
    for (int round = 0; round < rounds && failures < kMostFailures; ++round) {
      if (out_.gradient.x[0].size() != 2 * out_.curve.cells()) return;
      set_weights(out_, weight_, task.limits.position, work_.weight);
      const TimeGradient& g = out_.gradient;
      step_tube(out_.curve, {{g.x[0], g.x[1], g.x[2]}, {g.y[0], g.y[1], g.y[2]}}, work_.weight,
                judged_s(out_), work_.tube, work_.curve.coarse);
      measure(task);
      const double over = trial_.deviation_mm - allowed_mm(task.options);
      if (!holds(trial_, task.options)) {
        widen_tube(hold_mm(task.options) - trial_.points_off_mm - kBelow * hold_mm(task.options), work_.tube);
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
      weight_ *= faster ? kLighter : kHeavier;
      failures = faster && judged_s(trial_) < (1.0 - kGain) * judged_s(out_) ? 0 : failures + 1;
      if (!faster) continue;
      std::swap(trial_, out_);
      work_.tube.base = work_.tube.control;
    }
  }

 private:
  void fit(double radius, const CertifiedTask& task) {
    const CellSizes sizes = cell_sizes(points_, speed_limit_, {}, task, work_);
    fit_tube(points_,
             {.radius_mm = radius,
              .between_mm = samples_ ? kSagittaMm : radius,
              .most_between_mm = most_between_mm(task.options),
              .largest_mm = sizes.largest_mm,
              .tolerance_mm = allowed_mm(task.options),
              .hold_lines = hold_lines_ && hold_mm(task.options) > 0.0},
             work_.tube, work_.curve.coarse);
    work_.curve.offset.assign({0.0, work_.curve.coarse.s.back()});
  }

  /// The same inside the tolerance, if a tube that is narrower in places brings it there.
  void fit_inside(double radius, const CertifiedTask& task) {
    fit(radius, task);
    for (int tries = 0;; ++tries) {
      measure(task);
      if (trial_.deviation_mm <= allowed_mm(task.options) || tries == kShrinks || work_.curve.coarse.straight)
        return;
      narrow(task);
      refit_tube(work_.tube, work_.curve.coarse);
    }
  }

  /// Descent will begin at the present fit of this radius, which `out_` is planned along, in a tube as wide
  /// as the tolerance: it is narrowed where a step leaves that.
  void begin(double radius, double widest) {
    if (!samples_) widen_tube(widest - kInside * radius, work_.tube);
    work_.tube.base = work_.tube.control;
    weight_ = kFirstWeight;
  }

  /// Sets the trial's distances of the present curve from the path and from held points.
  void measure(const CertifiedTask& task) {
    const Curve& curve = work_.curve.coarse;
    trial_.deviation_mm = frechet_bound(curve, reference_.points) + reference_.sagitta_mm;
    trial_.points_off_mm =
        hold_mm(task.options) > 0.0 ? farthest_point_mm(curve, points_, hold_mm(task.options)) : 0.0;
  }

  /// Narrows the tube where the present curve is outside of the tolerance.
  void narrow(const CertifiedTask& task) {
    const double allowed = allowed_mm(task.options);
    find_stretches_beyond(work_.curve.coarse, reference_.points,
                          std::max(0.0, allowed - reference_.sagitta_mm), work_.beyond);
    narrow_tube(work_.beyond, kBelow * allowed, work_.tube);
  }

  void plan(double most_s, const CertifiedTask& task, StopSegment& segment) {
    plan_curve(points_, speed_limit_, {}, cell_sizes(points_, speed_limit_, {}, task, work_), most_s, task,
               work_, segment);
  }

  /// Plans along the fit of this radius, which becomes `out_` where it is faster, or the first. Returns its
  /// duration, unlimited where it is outside of the tolerance.
  double try_radius(double radius, const CertifiedTask& task) {
    fit_inside(radius, task);
    const bool first = std::exchange(first_, false);
    if (!first && trial_.deviation_mm > allowed_mm(task.options)) return kUnlimited;
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

  std::span<const Point2> points_;
  GivenReference reference_;
  std::span<const double> speed_limit_;
  CertifiedWork& work_;
  StopSegment &trial_, &out_;
  bool first_ = true, samples_ = false, hold_lines_ = true;
  double weight_ = kFirstWeight;
};

}  // namespace

void plan_fitted(std::span<const Point2> points, std::span<const double> speed_limit,
                 std::span<const GivenCurve> given, const CertifiedTask& task, CertifiedWork& work,
                 StopSegment& out) {
  FitPlanner planner(points, speed_limit, given, work, out);
  const bool slow = task.options.method == Method::kOptimal;
  // the slow tier does most of its descent on the fast tier's cells
  PlanOptions options = task.options;
  options.method = Method::kCertified;
  const CertifiedTask fast{task.arm, task.limits, options, task.placement, task.joints, task.groups};
  const bool moves = planner.start(fast);
  if (moves) planner.descend(kRounds, fast);
  if (!slow && moves) planner.refine(fast);
  if (!slow) return;
  if (!moves) {  // a straight line, or no curve within the tolerance
    FitPlanner(points, speed_limit, given, work, out).start(task);
    return;
  }
  planner.plan_again(task);
  planner.descend(kLastRounds, task);
}

}  // namespace firn::motion
