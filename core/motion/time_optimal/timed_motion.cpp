#include "core/motion/time_optimal/timed_motion.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"

namespace firn::motion {

namespace {

/// s = s0 + v0 x + a0 x^2 / 2 + c3 x^3 + c4 x^4 + c5 x^5 through the end's s, v, a.
struct Quintic {
  Quintic(const TimedMotion& m, std::size_t k) {
    const double T = m.t[k + 1] - m.t[k], over = 1.0 / T, over2 = over * over;
    const double ds =
        ((m.s[k + 1] - m.s[k]) * over - m.v[k]) * over - 0.5 * m.a[k];  // rest of s, units of T^2
    const double dv = (m.v[k + 1] - m.v[k]) * over - m.a[k];            // of v, in units of T
    const double da = m.a[k + 1] - m.a[k];
    c3 = (10.0 * ds - 4.0 * dv + 0.5 * da) * over;
    c4 = (-15.0 * ds + 7.0 * dv - da) * over2;
    c5 = (6.0 * ds - 3.0 * dv + 0.5 * da) * over2 * over;
  }
  double c3, c4, c5;
};

}  // namespace

namespace {

PathState state_at(const TimedMotion& m, std::size_t k, const Quintic& q, double x) {
  PathState p;
  p.s = m.s[k] + x * (m.v[k] + x * (0.5 * m.a[k] + x * (q.c3 + x * (q.c4 + x * q.c5))));
  p.v = m.v[k] + x * (m.a[k] + x * (3.0 * q.c3 + x * (4.0 * q.c4 + x * 5.0 * q.c5)));
  p.a = m.a[k] + x * (6.0 * q.c3 + x * (12.0 * q.c4 + x * 20.0 * q.c5));
  p.j = 6.0 * q.c3 + x * (24.0 * q.c4 + x * 60.0 * q.c5);
  return p;
}

}  // namespace

PathState TimedMotion::state(std::size_t k, double at) const {
  return state_at(*this, k, Quintic(*this, k), at - t[k]);
}

void TimedMotion::states(std::size_t k, std::size_t steps, std::vector<PathState>& out) const {
  const Quintic q(*this, k);
  const double from = t[k], span = t[k + 1] - from;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double at = i == steps ? t[k + 1] : from + span * double(i) / double(steps);
    out.push_back(state_at(*this, k, q, at - from));
  }
}

TimedMotion::Higher TimedMotion::higher(std::size_t k, double from, double to) const {
  const Quintic q(*this, k);
  return {24.0 * q.c4 + 120.0 * q.c5 * (from - t[k]), 24.0 * q.c4 + 120.0 * q.c5 * (to - t[k]), 120.0 * q.c5};
}

void time_profile(const Curve& curve, const Profile& profile, TimedMotion& motion) {
  static constexpr double at[4] = {0.069431844202973714, 0.33000947820757187, 0.66999052179242813,
                                   0.93056815579702629};
  static constexpr double weight[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                       0.17392742256872693};
  const std::size_t n = curve.cells();
  motion.t.resize(n + 1);
  motion.s = curve.s;
  motion.v.resize(n + 1);
  motion.a.resize(n + 1);
  motion.t[0] = 0.0;
  for (std::size_t i = 0; i <= n; ++i) {
    motion.v[i] = std::sqrt(profile.b[i]);
    motion.a[i] = 0.5 * profile.slope[i];
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double h = curve.s[i + 1] - curve.s[i];
    double sum = 0.0;
    if ((i == 0 && profile.b[0] == 0.0) || i == n - 1) {
      sum = 3.0 / motion.v[i == 0 ? 1 : n - 1];
    } else {
      const double slope = profile.slope[i] * h, curve2 = (profile.slope[i + 1] - profile.slope[i]) * h,
                   bend = profile.bend[i];
      for (int k = 0; k < 4; ++k) {
        const double x = at[k];
        const double b = profile.b[i] + x * (slope + x * curve2 * (0.5 - 0.25 * bend + bend * x / 6.0));
        sum += weight[k] / std::sqrt(b);
      }
    }
    motion.t[i + 1] = motion.t[i] + h * sum;
  }
}

void straight_motion(double length, double speed, double acceleration, double jerk, TimedMotion& motion) {
  // rise: jerk +, none, -: duration t1, t2, t1; then cruise
  double t1 = 0.0, t2 = 0.0, cruise = 0.0;
  if (speed * jerk >= acceleration * acceleration) {
    t1 = acceleration / jerk;
    if (length >= speed * (speed / acceleration + t1)) {
      t2 = speed / acceleration - t1;
      cruise = length / speed - speed / acceleration - t1;
    } else if (length >= 2.0 * acceleration * t1 * t1) {
      // v (v / a + a / j) = L
      const double v = 0.5 * acceleration * (std::sqrt(t1 * t1 + 4.0 * length / acceleration) - t1);
      t2 = v / acceleration - t1;
    } else {
      t1 = exact::cbrt(0.5 * length / jerk);
    }
  } else {
    t1 = std::sqrt(speed / jerk);
    if (length >= 2.0 * speed * t1)
      cruise = length / speed - 2.0 * t1;
    else
      t1 = exact::cbrt(0.5 * length / jerk);
  }
  const double jerks[7] = {jerk, 0.0, -jerk, 0.0, -jerk, 0.0, jerk},
               spans[7] = {t1, t2, t1, cruise, t1, t2, t1};
  motion.t.assign(1, 0.0);
  motion.s.assign(1, 0.0);
  motion.v.assign(1, 0.0);
  motion.a.assign(1, 0.0);
  double t = 0.0, s = 0.0, v = 0.0, a = 0.0;
  for (int k = 0; k < 7; ++k) {
    const double x = spans[k], j = jerks[k];
    if (x <= 1e-12) continue;
    t += x;
    s += x * (v + x * (0.5 * a + x * j / 6.0));
    v += x * (a + 0.5 * x * j);
    a += x * j;
    motion.t.push_back(t);
    motion.s.push_back(s);
    motion.v.push_back(v);
    motion.a.push_back(a);
  }
  motion.s.back() = length;
  motion.v.back() = motion.a.back() = 0.0;
}

}  // namespace firn::motion
