#include "core/motion/thesis/acon.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/exact/exact_math.h"
#include "core/motion/thesis/sections.h"

namespace firn::motion::thesis {
namespace {

constexpr double kDurationRounding = 1.0 + 1e-9;  ///< a smaller change of a duration is rounding

double slower_side(const Ladder& ladder, const std::vector<double>& dt, std::size_t i) {
  const double left = i > 0 ? ladder.step[i - 1] / dt[i - 1] : kUnlimited;
  const double right = i < dt.size() ? ladder.step[i] / dt[i] : kUnlimited;
  return std::min(left, right);
}

/// One subgroup of adjacent violating points [first, last] inside the section: both curves from its slowest
/// point.
bool correct_group(const Ladder& ladder, const std::vector<double>& acceleration, std::size_t first,
                   std::size_t last, const Section& section, const RateLimits& limits,
                   std::vector<double>& dt) {
  std::size_t slowest = first;
  for (std::size_t i = first; i <= last; ++i)
    if (slower_side(ladder, dt, i) < slower_side(ladder, dt, slowest)) slowest = i;
  CurveStart start{slowest, slower_side(ladder, dt, slowest), 0.0};
  // A side that complies hands its acceleration on; the definition keeps it positive along the curve.
  const auto carried = [&](std::size_t neighbour, int direction) {
    return std::clamp(direction * acceleration[neighbour], 0.0, limits.acceleration);
  };
  CurveStart back = start;
  if (slowest == first && first > section.first) start.acceleration = carried(first - 1, +1);
  if (slowest == last && last < section.last) back.acceleration = carried(last + 1, -1);
  // A joint that turns round does so at its highest acceleration, not at none.
  if (slowest == section.first) start.acceleration = carried(slowest, +1);
  if (slowest == section.last) back.acceleration = carried(slowest, -1);
  const bool forward = acceleration_curve(ladder, start, +1, section.last, limits, dt);
  return acceleration_curve(ladder, back, -1, section.first, limits, dt) || forward;
}

bool correct(const Ladder& ladder, const std::vector<bool>& violates, const std::vector<double>& acceleration,
             const Section& section, const RateLimits& limits, std::vector<double>& dt) {
  bool raised = false;
  for (std::size_t i = section.first; i <= section.last; ++i) {
    if (!violates[i]) continue;
    std::size_t last = i;
    while (last < section.last && violates[last + 1]) ++last;
    raised = correct_group(ladder, acceleration, i, last, section, limits, dt) || raised;
    i = last;
  }
  return raised;
}

bool correct_position(Profile& profile, const RateLimits& limits, const Margins& margins) {
  const std::size_t n = profile.size();
  const TotalRates total = total_rates(profile);
  const Rates along = rates(profile.s_mm, profile.dt_s);
  std::vector<bool> violates(n);
  for (std::size_t i = 0; i < n; ++i) {
    violates[i] = total.acceleration[i] > (1.0 + margins.acceleration) * limits.acceleration;
    for (const std::size_t k : {i - 1, i})  // the intervals on both sides; i - 1 wraps beyond n at the start
      if (k < n - 1 && along.jerk[k] > (1.0 + margins.jerk) * limits.jerk) violates[i] = true;
  }
  Ladder ladder{std::vector<double>(n - 1), radii(profile.points)};
  for (std::size_t i = 0; i + 1 < n; ++i) ladder.step[i] = profile.s_mm[i + 1] - profile.s_mm[i];
  return correct(ladder, violates, along.acceleration, {0, n - 1, 1}, limits, profile.dt_s);
}

bool correct_joint(Profile& profile, std::size_t joint, const RateLimits& limits, const Margins& margins) {
  const std::size_t n = profile.size();
  const std::vector<double>& q = profile.joints[joint];
  Ladder ladder{std::vector<double>(n - 1), std::vector<double>(n, kUnlimited)};
  for (std::size_t i = 0; i + 1 < n; ++i) ladder.step[i] = std::abs(q[i + 1] - q[i]);
  bool raised = false;
  for (const Section& section : sections(q)) {
    const Rates r = rates(q, profile.dt_s);
    std::vector<double> acceleration(n);
    std::vector<bool> violates(n);
    for (std::size_t i = section.first; i <= section.last; ++i) {
      acceleration[i] = section.sign * r.acceleration[i];
      violates[i] = std::abs(r.acceleration[i]) > (1.0 + margins.acceleration) * limits.acceleration;
      for (const std::size_t k : {i - 1, i})
        if (k < n - 1 && section.sign * r.jerk[k] > (1.0 + margins.jerk) * limits.jerk) violates[i] = true;
    }
    raised = correct(ladder, violates, acceleration, section, limits, profile.dt_s) || raised;
  }
  return raised;
}

}  // namespace

double time_over_distance(double jerk, double acceleration, double speed, double distance) {
  if (distance <= 0.0) return 0.0;
  // Each bound neglects two terms, so the root lies below all three; f is convex for t > 0, so Newton's steps
  // descend onto it from there without overshooting.
  double t = exact::cbrt(6.0 * distance / jerk);
  if (acceleration > 0.0) t = std::min(t, std::sqrt(2.0 * distance / acceleration));
  if (speed > 0.0) t = std::min(t, distance / speed);
  for (int k = 0; k < 40; ++k) {
    const double f = ((jerk / 6.0 * t + acceleration / 2.0) * t + speed) * t - distance;
    const double slope = (jerk / 2.0 * t + acceleration) * t + speed;
    const double next = t - f / slope;
    if (!(next < t)) break;
    t = next;
  }
  return t;
}

bool acceleration_curve(const Ladder& ladder, CurveStart start, int direction, std::size_t end,
                        const RateLimits& limits, std::vector<double>& dt) {
  double c = start.speed, a0 = start.acceleration;
  std::size_t i = start.point;
  bool raised = false, begun = false;
  while (i != end) {
    const std::size_t k = direction > 0 ? i : i - 1, next = direction > 0 ? i + 1 : i - 1;
    const double ds = ladder.step[k], radial = c * c / ladder.radius[i];
    const double tangential = radial < limits.acceleration
                                  ? std::sqrt(limits.acceleration * limits.acceleration - radial * radial)
                                  : 0.0;
    const double dt_a =
        2.0 * ds / (c + std::sqrt(c * c + 2.0 * tangential * ds));  // = (-c + sqrt(...)) / a_t
    const double dt_j = time_over_distance(limits.jerk, a0, c, ds);
    const double wanted = std::max(dt_a, dt_j);
    if (ds > 0.0 && wanted < dt[k]) {
      if (begun) break;
      const double along = std::max(0.0, 2.0 * ds / dt[k] - c);  // speed at the far end if it changes evenly
      a0 = std::clamp((along - c) / dt[k], 0.0, limits.acceleration);
      c = along;
      i = next;
      continue;
    }
    begun = true;
    const bool by_acceleration = dt_a > dt_j;
    raised = raised || wanted > kDurationRounding * dt[k];
    dt[k] = std::max(dt[k], wanted);
    const double a1 = by_acceleration ? tangential : a0, j1 = by_acceleration ? 0.0 : limits.jerk;
    c += a1 * wanted + j1 * wanted * wanted / 2.0;
    a0 = a1 + j1 * wanted;
    i = next;
  }
  return raised;
}

void acon(Profile& profile, const MotionLimits& limits, const Margins& margins, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    bool raised = correct_position(profile, limits.position, margins);
    for (std::size_t j = 0; j < profile.joints.size(); ++j)
      raised = correct_joint(profile, j, limits.joint[j], margins) || raised;
    if (!raised) return;
  }
}

}  // namespace firn::motion::thesis
