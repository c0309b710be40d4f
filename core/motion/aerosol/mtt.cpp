#include "core/motion/aerosol/mtt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/aerosol/lspb.h"
#include "core/motion/kinematics/fault.h"

namespace firn::motion {
namespace {

constexpr double kUnlimited_s = std::numeric_limits<double>::infinity();
constexpr double kDurationRounding = 1e-9;  // of the longest time in a move

double root_of(double lambda, double scale) {
  return lambda < 0 && lambda > -1e-13 * scale ? 0.0 : std::sqrt(lambda);
}

// (36) to (38). The sign is that of the peak, which the bounds (31), (32) make that of q1 - q0; (37) without
// the sign that is printed before v_max (1 / (2 alpha) + 1 / (2 alpha)).
AxisProfile at_full_speed(const AxisEnds& e, double t0, double sign, const AxisLimits& limits) {
  const double v = limits.v_max_mm_s, alpha = limits.alpha_mm_s2, v0 = e.v0_mm_s, v1 = e.v1_mm_s;
  AxisProfile p{e, t0, 0, 0, 0, sign * v, sign * alpha, -sign * alpha};
  p.t1_s = sign * ((e.q1_mm - e.q0_mm) / v - v1 / alpha - v0 / alpha) + v / alpha +
           (v1 * v1 + v0 * v0) / (2.0 * alpha * v) + t0;                    // (37)
  p.tb0_s = std::min((v - sign * v0) / alpha + t0, p.t1_s);                 // (36)
  p.tb1_s = std::clamp((sign * v1 - v) / alpha + p.t1_s, p.tb0_s, p.t1_s);  // (38)
  return p;
}

std::optional<AxisProfile> with_peak(const AxisEnds& e, double t0, double vp, double a0,
                                     const AxisLimits& limits) {
  if (!std::isfinite(vp)) return std::nullopt;
  const double alpha = limits.alpha_mm_s2;
  double tb = (vp - e.v0_mm_s) / a0 + t0;   // (19)
  double t1 = (e.v1_mm_s - vp) / -a0 + tb;  // (20)
  const double slack = kDurationRounding * (std::abs(vp) + std::abs(e.v0_mm_s) + std::abs(e.v1_mm_s)) / alpha;
  if (tb < t0 - slack || t1 < tb - slack) return std::nullopt;                                     // (28)
  if (std::abs(vp) > limits.v_max_mm_s) return at_full_speed(e, t0, vp > 0 ? 1.0 : -1.0, limits);  // (29)
  tb = std::max(tb, t0);
  t1 = std::max(t1, tb);
  return AxisProfile{e, t0, tb, tb, t1, vp, a0, -a0};
}

// Durations in which the farthest that the axis can get is at least q1: dmax(T) >= dq. The farthest grows
// with the duration at the speed of the peak; while both boundary speeds are negative it first shrinks.
std::vector<Durations> far_enough(const AxisEnds& e, const AxisLimits& limits) {
  const double alpha = limits.alpha_mm_s2, v0 = e.v0_mm_s, v1 = e.v1_mm_s, dq = e.q1_mm - e.q0_mm;
  const double shortest = std::abs(v1 - v0) / alpha, direct = 0.5 * (v0 + v1) * shortest;
  const double squares = v0 * v0 + v1 * v1;
  const double lambda = alpha * dq + 0.5 * squares;  // (24)
  const auto at_peak = [&](double vp) { return std::max(shortest, (2.0 * vp - v0 - v1) / alpha); };
  const auto reached = [&] {
    const double vp = root_of(lambda, squares);
    return vp > limits.v_max_mm_s ? at_full_speed(e, 0.0, 1.0, limits).t1_s : at_peak(vp);
  };
  const double slack = 1e-12 * (std::abs(dq) + squares / alpha);
  if (dq > direct + slack) return {{reached(), kUnlimited_s}};
  if (std::max(v0, v1) >= 0.0 || lambda <= 0.0) return {{shortest, kUnlimited_s}};
  return {{shortest, at_peak(-std::sqrt(lambda))}, {reached(), kUnlimited_s}};
}

AxisEnds mirrored(const AxisEnds& e) { return {-e.q0_mm, -e.q1_mm, -e.v0_mm_s, -e.v1_mm_s}; }

std::vector<Durations> common(const std::vector<Durations>& a, const std::vector<Durations>& b) {
  std::vector<Durations> both;
  for (const Durations& one : a)
    for (const Durations& other : b)
      if (const Durations d{std::max(one.from_s, other.from_s), std::min(one.to_s, other.to_s)};
          d.from_s <= d.to_s)
        both.push_back(d);
  std::ranges::sort(both, {}, &Durations::from_s);
  return both;
}

AxisProfile in_duration(const AxisEnds& e, double t0, double duration, const AxisLimits& limits, int axis) {
  // At its own minimum the triangle is exact; elsewhere the trapezoid of III.
  const AxisProfile fastest = mtt(e, t0, limits);
  if (fastest.t1_s == t0 + duration) return fastest;
  if (const std::optional<AxisProfile> p = lspb(e, t0, t0 + duration, limits.alpha_mm_s2)) return *p;
  if (std::abs(fastest.t1_s - t0 - duration) <= kDurationRounding * duration) return fastest;
  Fault fault(Reason::kNoSolution);
  fault.axis = axis;
  fault.value = duration;
  fault.what = "duration of a two-axis move";
  throw MotionError(fault);
}

}  // namespace

MttCandidates mtt_candidates(const AxisEnds& e, double t0, const AxisLimits& limits) {
  const double alpha = limits.alpha_mm_s2, squares = e.v0_mm_s * e.v0_mm_s + e.v1_mm_s * e.v1_mm_s;
  // (24), (26) with the sum of the squares; as printed, their difference, the end is missed.
  const double lambda_1 = alpha * (e.q1_mm - e.q0_mm) + 0.5 * squares;
  const double lambda_2 = alpha * (e.q0_mm - e.q1_mm) + 0.5 * squares;
  const double vp_1 = root_of(lambda_1, squares),
               vp_2 = root_of(lambda_2, squares);  // NaN when imaginary (27)
  return {with_peak(e, t0, vp_1, alpha, limits), with_peak(e, t0, -vp_1, alpha, limits),     // (23)
          with_peak(e, t0, vp_2, -alpha, limits), with_peak(e, t0, -vp_2, -alpha, limits)};  // (25)
}

AxisProfile mtt(const AxisEnds& ends, double t0, const AxisLimits& limits) {
  std::optional<AxisProfile> best;
  for (const std::optional<AxisProfile>& c : mtt_candidates(ends, t0, limits))
    if (c && (!best || c->t1_s < best->t1_s)) best = c;
  if (best) return *best;
  Fault fault(Reason::kNoSolution);
  fault.what = "minimum-time move of one axis";
  throw MotionError(fault);
}

std::vector<Durations> possible_durations(const AxisEnds& ends, const AxisLimits& limits) {
  return common(far_enough(ends, limits), far_enough(mirrored(ends), limits));
}

PlaneMove synchronised_mtt(const AxisEnds& x, const AxisEnds& y, double t0, const AxisLimits& limits,
                           double at_least) {
  const std::vector<Durations> late_enough{{at_least, kUnlimited_s}};
  const std::vector<Durations> both =
      common(common(possible_durations(x, limits), possible_durations(y, limits)), late_enough);
  const double duration = both.front().from_s;  // never empty: each axis' last interval has no end
  return {in_duration(x, t0, duration, limits, 0), in_duration(y, t0, duration, limits, 1)};
}

}  // namespace firn::motion
