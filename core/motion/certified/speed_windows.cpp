// SpeedPlanner's windows: a long curve is planned from one end to the other in windows of some thousand
// cells, so that memory does not grow with the path beside its result, and no step of the solver waits for
// the worst place of the whole path.
//
// A window ends at rest. Its motion is kept up to a place from which several ways of stopping are left: what
// comes after has no influence there, and the next window, which begins there with the speed and acceleration
// reached, has a solution, the rest of this one.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/certified/deviation_limits.h"
#include "core/motion/certified/speed_planner.h"

namespace firn::motion {
namespace {

/// The values that a curve has at each knot; yaw and yaw2 may be empty.
constexpr std::vector<double> Curve::*kKnotValues[] = {&Curve::s,  &Curve::x,   &Curve::y,   &Curve::xx,
                                                       &Curve::yy, &Curve::yaw, &Curve::yaw2};

void append_range(const std::vector<double>& from, std::size_t first, std::size_t last,
                  std::vector<double>& to) {
  if (!from.empty())
    to.insert(to.end(), from.begin() + std::ptrdiff_t(first), from.begin() + std::ptrdiff_t(last));
}

/// Appends cells [first, last) of `from`, whose first knot is the last one of `to`.
void append_cells(const Curve& from, std::size_t first, std::size_t last, Curve& to) {
  const double shift = to.s.back() - from.s[first];
  const std::size_t knots = to.s.size();
  for (const auto values : kKnotValues) append_range(from.*values, first + 1, last + 1, to.*values);
  for (std::size_t i = knots; i < to.s.size(); ++i) to.s[i] += shift;
  append_range(from.speed_limit, first, last, to.speed_limit);
}

/// Cells [first, last) of a curve, lengths counted from there.
void part_of_curve(const Curve& from, std::size_t first, std::size_t last, Curve& to) {
  for (const auto values : kKnotValues) {
    (to.*values).clear();
    append_range(from.*values, first, last + 1, to.*values);
  }
  to.speed_limit.clear();
  append_range(from.speed_limit, first, last, to.speed_limit);
  to.straight = false;
  const double start = to.s.front();
  for (double& s : to.s) s -= start;
}

/// Pieces [first, last) of a motion, time and length counted from there.
void part_of_motion(const TimedMotion& from, std::size_t first, std::size_t last, TimedMotion& to) {
  for (auto of : {&TimedMotion::t, &TimedMotion::s, &TimedMotion::v, &TimedMotion::a})
    (to.*of).assign((from.*of).begin() + std::ptrdiff_t(first),
                    (from.*of).begin() + std::ptrdiff_t(last) + 1);
  for (auto of : {&TimedMotion::t, &TimedMotion::s}) {
    const double start = (to.*of).front();
    for (double& value : to.*of) value -= start;
  }
}

/// Way from speed v to rest by the tool's acceleration and jerk [mm].
double stopping_mm(double v, const RateLimits& limit) {
  const double stop_s = v * limit.jerk > limit.acceleration * limit.acceleration
                            ? v / limit.acceleration + limit.acceleration / limit.jerk
                            : 2.0 * std::sqrt(v / limit.jerk);
  return 0.5 * v * stop_s;
}

/// Largest square of the curvature at a curve's knots [1/mm^2].
double largest_square_curvature(const Curve& c) {
  double most = 0.0;
  for (std::size_t i = 0; i < c.cells(); ++i) {
    const double h = c.s[i + 1] - c.s[i];
    for (const double side : {0.0, 1.0}) {
      const auto slope = [&](const std::vector<double>& f, const std::vector<double>& m) {
        return (f[i + 1] - f[i]) / h +
               h * (side > 0.0 ? m[i] + 2.0 * m[i + 1] : -2.0 * m[i] - m[i + 1]) / 6.0;
      };
      const std::size_t at = i + std::size_t(side);
      const double x = slope(c.x, c.xx), y = slope(c.y, c.yy), square = x * x + y * y;
      const double turn = x * c.yy[at] - y * c.xx[at];
      most = std::max(most, turn * turn / (square * square * square));
    }
  }
  return most;
}

/// Cells at a window's start that are not divided: the profile goes on there.
constexpr std::size_t kGivenCells = 3;

}  // namespace

std::size_t SpeedPlanner::keep_window(const CertifiedTask& task, const Curve& undivided, bool last,
                                      StopSegment& out) {
  const Curve& curve = window_.curve;
  const TimedMotion& motion = window_.motion;
  const std::size_t begun = start_.b[0] > 0.0 ? 1 : 0;  // the cell before the start is the last one kept
  std::size_t kept = curve.cells();
  if (!last) {
    double fastest = 0.0;
    kept -= kMinOverlapCells;
    for (std::size_t i = kept; i < curve.cells(); ++i) fastest = std::max(fastest, motion.v[i]);
    const auto too_near = [&] {
      fastest = std::max(fastest, motion.v[kept]);
      return curve.s.back() - curve.s[kept] < kWindowStops * stopping_mm(fastest, task.limits.position);
    };
    const auto divided = [&] {
      return !std::binary_search(undivided.s.begin(), undivided.s.end(), curve.s[kept]);
    };
    while (kept > kGivenCells && (too_near() || divided())) --kept;
    if (kept < curve.cells() / 4) return 0;
  }
  append_cells(curve, begun, kept, out.curve);
  const double shift = out.motion.t.back() - motion.t[begun];
  for (std::size_t i = begun + 1; i <= kept; ++i) {
    out.motion.t.push_back(motion.t[i] + shift);
    out.motion.v.push_back(motion.v[i]);
    out.motion.a.push_back(motion.a[i]);
  }
  if (task.in_descent)
    for (int order = 0; order < 3; ++order)
      for (auto of : {&TimeGradient::x, &TimeGradient::y}) {
        const std::vector<double>& g = (window_.gradient.*of)[order];
        std::vector<double>& all = (out.gradient.*of)[order];
        all.insert(all.end(), g.begin() + 2 * std::ptrdiff_t(begun), g.begin() + 2 * std::ptrdiff_t(kept));
      }
  RatioTable ratios;
  if (sampled_ != window_.sampled) {
    ++sampled_;
    sample(task, 1, window_);
  }
  MotionSamples& samples = bounds_.samples;
  const std::size_t count = samples.batch.size() / curve.cells() * kept;
  samples.batch.state.resize(count);
  samples.batch.cell.resize(count);
  samples.batch.time.resize(count);
  add_ratios(curve, samples.batch, samples.tool, samples.joint, task.groups, ratios);
  out.ratios.merge(ratios, shift);
  start_.s.clear();
  start_.ahead.clear();
  for (std::size_t i = kept - 1; i <= curve.cells(); ++i) {
    start_.s.push_back(curve.s[i] - curve.s[kept - 1]);
    start_.ahead.push_back(motion.v[i] * motion.v[i]);
  }
  start_.ahead_mm = kFollowedShare * start_.s.back();
  for (std::size_t k = 0; k < 2; ++k) {
    start_.b[k] = start_.ahead[k];
    start_.slope[k] = 2.0 * motion.a[kept - 1 + k];
  }
  return kept - begun;
}

bool SpeedPlanner::plan_windows(const CellSizes& sizes, double max_s, const CertifiedTask& task,
                                StopSegment& out) {
  Curve whole = std::move(out.curve);
  const auto abandon = [&](bool done) {
    out.curve = std::move(whole);
    in_window_ = false;
    return done;
  };
  out.curve = {};
  part_of_curve(whole, 0, 0, out.curve);
  const std::size_t cells = whole.cells();
  for (auto of : {&Curve::s, &Curve::x, &Curve::y, &Curve::xx, &Curve::yy, &Curve::speed_limit})
    (out.curve.*of).reserve(cells + cells / 4);
  out.motion = {};
  for (auto of : {&TimedMotion::t, &TimedMotion::v, &TimedMotion::a}) {
    (out.motion.*of).reserve(cells + cells / 4);
    (out.motion.*of).push_back(0.0);
  }
  for (auto of : {&TimeGradient::x, &TimeGradient::y})
    for (auto& order : out.gradient.*of) order.clear();
  out.closed_form = out.proved = false;
  out.ratios = {};
  in_window_ = true;
  start_.b[0] = 0.0;
  CurveWork undivided;
  std::size_t size = kWindowCells;
  for (std::size_t next = 0; next < cells;) {  // the first cell of `whole` that is not begun
    const std::size_t begun = out.curve.cells() > 0 ? 1 : 0,
                      end = cells - next < 2 * size ? cells : next + size;
    Curve& part = undivided.coarse;
    if (begun) {
      const std::size_t before = out.curve.cells() - 1;
      part_of_curve(out.curve, before, before + 1, part);
      append_cells(whole, next, end, part);
    } else {
      part_of_curve(whole, next, end, part);
    }
    window_.curve = part;
    const bool first = begun == 0;
    const Finer finer = [&](Curve& fine) {
      if (!first) std::fill_n(excess_.begin(), kGivenCells, 0.0);
      divide(sizes, undivided, excess_, kCellFactor, fine);
      fine.speed_limit.clear();
      for (std::size_t i = 0, of = 0; i < fine.cells(); ++i) {
        while (part.s[of + 1] <= fine.s[i]) ++of;
        fine.speed_limit.push_back(part.speed_limit[of]);
      }
    };
    attempt(task, kUnlimited, finer, window_);
    if (!std::isfinite(window_.duration_s()) || !solved(window_)) return abandon(false);
    const std::size_t kept = keep_window(task, part, end == cells, out);
    if (kept == 0) {
      if (size >= kMaxWindowCells) return abandon(false);
      size *= 2;
      continue;
    }
    if (out.motion.t.back() > max_s) {
      abandon(true);
      give_up(out);
      return true;
    }
    const double place = window_.curve.s[begun + kept];
    const auto at = std::lower_bound(part.s.begin(), part.s.end(), place);
    next += std::size_t(at - part.s.begin()) - begun;
  }
  in_window_ = false;
  out.curve.straight = whole.straight;
  out.motion.s = out.curve.s;
  out.factor = out.ratios.time_factor();
  out.sampled = ++sampled_;
  return true;
}

void SpeedPlanner::prove_windows(const CertifiedTask& task, double sharpness, StopSegment& out) {
  const std::size_t cells = out.curve.cells();
  const double square_curvature = largest_square_curvature(out.curve),
               around_mm = kWindowStops * stopping_mm(task.limits.position.rate, task.limits.position);
  RatioTable bounds;
  out.bound_s = 0.0;
  for (std::size_t from = 0; from < cells; from += kWindowCells) {
    const std::size_t to = std::min(from + kWindowCells, cells);
    part_of_curve(out.curve, from, to, window_.curve);
    part_of_motion(out.motion, from, to, window_.motion);
    sample(task, 1, window_);
    const BoundedMotion bounded{window_.curve,  window_.motion, task.arm,
                                task.placement, task.groups,    task.joints};
    RatioTable here = out.ratios;
    if (auto fault = bound_motion(bounded, sharpness, bounds_, here)) throw MotionError(*fault);
    bounds.merge(here, out.motion.t[from]);
    if (!task.options.lower_bound) continue;
    // a bound of the speed at every place holds whatever the motion is beyond the part about it
    std::size_t first = from, last = to;
    while (first > 0 && from - first < kWindowCells && out.curve.s[from] - out.curve.s[first] < around_mm)
      --first;
    while (last < cells && last - to < kWindowCells && out.curve.s[last] - out.curve.s[to] < around_mm)
      ++last;
    part_of_curve(out.curve, first, last, window_.curve);
    set_rows(task, window_);
    const BoundPart part{first > 0 ? kUnlimited : 0.0, last < cells ? kUnlimited : 0.0, true,
                         square_curvature};
    speed_bound(window_.curve, rows_, task.groups, task.groups.count, bound_, part);
    if (!task.options.bound_without_jerk) tighten_bound(window_.curve, rows_, task.groups, bound_, part);
    set_duration(window_.curve, rows_, task.groups, from - first, to - first, bound_);
    out.bound_s += bound_.duration_s;
  }
  out.ratios = bounds;
}

}  // namespace firn::motion
