#include "core/motion/thesis/jcon.h"

#include <algorithm>
#include <cmath>

#include "core/motion/thesis/sections.h"

namespace firn::motion::thesis {
namespace {

/// Replaces the rates between left and right by the polynomial's, wherever that is slower and still moves.
void spread(const Interval& interval, const std::vector<double>& rate,
            const std::vector<double>& acceleration, std::vector<double>& dt) {
  const auto at_point = [&](std::size_t i) {
    return i == 0 ? rate.front() : i >= rate.size() ? rate.back() : 0.5 * (rate[i - 1] + rate[i]);
  };
  double total = 0.0;
  for (std::size_t k = interval.left; k < interval.right; ++k) total += dt[k];
  const CubicSpeed cubic = cubic_speed(at_point(interval.left), at_point(interval.right),
                                       acceleration[interval.left], acceleration[interval.right], total);
  double before = 0.0;
  for (std::size_t k = interval.left; k < interval.right; ++k) {
    const double speed = cubic.at((before + 0.5 * dt[k]) / total);
    before += dt[k];
    if (speed > 0.0 && speed < rate[k]) dt[k] *= rate[k] / speed;
  }
}

/// One coordinate over one section, seen in its direction of motion.
void smooth_section(const std::vector<double>& values, const Section& section, const RateLimits& limits,
                    const Margins& margins, std::vector<double>& dt) {
  Rates r = rates(values, dt);
  for (double& x : r.rate) x *= section.sign;
  for (double& x : r.acceleration) x *= section.sign;
  for (double& x : r.jerk) x *= section.sign;
  const double spike = -(1.0 + margins.jerk) * limits.jerk;
  std::vector<Interval> intervals;
  for (std::size_t k = section.first; k < section.last; ++k) {
    if (r.jerk[k] >= spike) continue;
    std::size_t last = k;
    while (last + 1 < section.last && r.jerk[last + 1] < spike) ++last;
    intervals.push_back(grow({k, last + 1}, r.acceleration, dt, limits.jerk, {section.first, section.last}));
    k = last;
  }
  for (const Interval& interval : intervals) spread(interval, r.rate, r.acceleration, dt);
}

}  // namespace

Interval grow(Interval i, const std::vector<double>& a, const std::vector<double>& dt, double jerk,
              Interval section) {
  bool left_halted = false, right_halted = false;
  double total = 0.0;
  for (std::size_t k = i.left; k < i.right; ++k) total += dt[k];
  do {
    if (!left_halted) {
      left_halted = i.left == section.left || a[i.left - 1] * a[i.left] < 0.0;
      if (!left_halted) total += dt[--i.left];
    }
    if (!right_halted) {
      right_halted = i.right == section.right || a[i.right + 1] * a[i.right] < 0.0;
      if (!right_halted) total += dt[i.right++];
    }
  } while (std::abs(a[i.right] - a[i.left]) / total >= jerk && !(left_halted && right_halted));
  return i;
}

CubicSpeed cubic_speed(double v0, double v1, double a0, double a1, double dt) {
  CubicSpeed v;
  v.a = v0;
  v.b = a0 * dt;
  v.c = 3.0 * v1 - a1 * dt - 3.0 * v.a - 2.0 * v.b;
  v.d = v1 - v.a - v.b - v.c;
  return v;
}

void jcon(Profile& profile, const MotionLimits& limits, const Margins& margins) {
  smooth_section(profile.s_mm, {0, profile.size() - 1, 1}, limits.position, margins, profile.dt_s);
  for (std::size_t j = 0; j < profile.joints.size(); ++j)
    for (const Section& section : sections(profile.joints[j]))
      smooth_section(profile.joints[j], section, limits.joint[j], margins, profile.dt_s);
}

}  // namespace firn::motion::thesis
