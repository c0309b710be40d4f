// Computes moves of one axis by stepping through time, without the planner's formulas.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/grid/random.h"
#include "core/motion/aerosol/mtt.h"

namespace firn::test {

class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : stream_(seed, Purpose::kTest) {}
  double operator()(double low, double high) { return stream_.uniform(low, high); }

 private:
  RandomStream stream_;
};

inline motion::AxisEnds random_ends(Numbers& next, double span_mm, double v_max) {
  return {next(-span_mm, span_mm), next(-span_mm, span_mm), next(-v_max, v_max), next(-v_max, v_max)};
}

/// Nearest and farthest displacement that an axis with |a| <= alpha, |v| <= v_max reaches in `duration` from
/// v0 to v1: by the midpoint rule over the fastest and the slowest speed that both ends allow at each
/// instant. first > second: none.
inline std::pair<double, double> reachable(const motion::AxisEnds& e, double duration,
                                           const motion::AxisLimits& l, int steps = 4000) {
  if (std::abs(e.v1_mm_s - e.v0_mm_s) > l.alpha_mm_s2 * duration * (1 + 1e-12)) return {1.0, -1.0};
  double low = 0.0, high = 0.0;
  const double dt = duration / steps;
  for (int n = 0; n < steps; ++n) {
    const double t = (n + 0.5) * dt, back = duration - t;
    high += dt * std::min({e.v0_mm_s + l.alpha_mm_s2 * t, e.v1_mm_s + l.alpha_mm_s2 * back, l.v_max_mm_s});
    low += dt * std::max({e.v0_mm_s - l.alpha_mm_s2 * t, e.v1_mm_s - l.alpha_mm_s2 * back, -l.v_max_mm_s});
  }
  return {low, high};
}

inline bool can(const motion::AxisEnds& e, double duration, const motion::AxisLimits& l, int steps = 4000) {
  const auto [low, high] = reachable(e, duration, l, steps);
  return low <= e.q1_mm - e.q0_mm && e.q1_mm - e.q0_mm <= high;
}

/// End of the profile by integrating its speed; the trapezoid rule is exact where no blend ends inside a
/// step.
inline double integrated_end(const motion::AxisProfile& p, int steps = 20000) {
  double q = p.ends.q0_mm;
  const double dt = (p.t1_s - p.t0_s) / steps;
  for (int n = 0; n < steps; ++n)
    q += 0.5 * dt * (p.velocity(p.t0_s + n * dt) + p.velocity(p.t0_s + (n + 1) * dt));
  return q;
}

}  // namespace firn::test
