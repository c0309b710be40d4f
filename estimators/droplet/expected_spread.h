// Computes the expected flow from a droplet to a neighbour when the surface is known only to a variance: the
// mean of w sat_{h1+w}(d) [Lu 2015, Eq. (5)] over the error of d. Taking sat at the measured difference
// instead would count every error in one direction only, for sat bends at 0 (errors in variables).
#pragma once

#include <emmintrin.h>

#include <cmath>

namespace firn::droplet {

/// Mean of max(0, x + e), e of the given variance. The error's density is (15/16)(1 - (e/c)^2)^2 / c on [-c,
/// c], c^2 = 7 variance: near a normal one (at x = 0: 0.413 instead of 0.399 standard deviations), and only +
/// - * / sqrt, so that every machine has the same bytes.
inline double mean_ramp(double x, double variance) {
  const double c2 = 7.0 * variance;
  if (x * x >= c2) return x > 0.0 ? x : 0.0;
  const double c = std::sqrt(c2), t = x / c, t2 = t * t;
  return c * (0.15625 + t * 0.5 + 0.9375 * t2 * (0.5 - t2 * (1.0 / 6.0 - t2 * (1.0 / 30.0))));
}

/// Derivative of mean_ramp by x: the probability that x + e > 0.
inline double step_probability(double x, double variance) {
  const double c2 = 7.0 * variance;
  if (x * x >= c2) return x > 0.0 ? 1.0 : 0.0;
  const double t = x / std::sqrt(c2), t2 = t * t;
  return 0.5 + 0.9375 * t * (1.0 - t2 * (2.0 / 3.0 - t2 * 0.2));
}

/// Two numbers side by side: the same operations in the same order as above, hence the same bytes.
using Two = double __attribute__((vector_size(16)));
inline Two root(Two x) { return _mm_sqrt_pd(x); }

inline Two mean_ramp(Two x, Two variance) {
  const Two c2 = 7.0 * variance, x2 = x * x, far = x > 0.0 ? x : Two{};
  if (_mm_movemask_pd(x2 >= c2) == 3) return far;  // so it is mostly for a neighbour that is low enough
  const Two c = root(c2), t = x / c, t2 = t * t;   // c = 0: t is not used
  const Two near = c * (0.15625 + t * 0.5 + 0.9375 * t2 * (0.5 - t2 * (1.0 / 6.0 - t2 * (1.0 / 30.0))));
  return x2 >= c2 ? far : near;
}

inline Two step_probability(Two x, Two variance) {
  const Two c2 = 7.0 * variance, x2 = x * x, far = x > 0.0 ? Two{1.0, 1.0} : Two{};
  if (_mm_movemask_pd(x2 >= c2) == 3) return far;
  const Two t = x / root(c2), t2 = t * t;
  const Two near = 0.5 + 0.9375 * t * (1.0 - t2 * (2.0 / 3.0 - t2 * 0.2));
  return x2 >= c2 ? far : near;
}

/// A link of a droplet to a neighbour, at uncertain heights.
struct SoftLink {
  double w_mm = 0.0;                ///< h2 or h3
  double slope = 0.0;               ///< w / (h1 + w)
  double reach_mm = 0.0;            ///< h1 + w: so far uphill nothing flows any more
  double reach_variance_mm2 = 0.0;  ///< of reach_mm, by the scatter of droplets

  /// @param d_mm mean of (own height - neighbour's), @param variance_mm2 of it
  template <class Number>
  Number spread_mm(Number d_mm, Number variance_mm2) const {
    return w_mm - slope * (mean_ramp(-d_mm, variance_mm2) -
                           mean_ramp(-d_mm - reach_mm, variance_mm2 + reach_variance_mm2));
  }
  /// Derivative of spread_mm by d_mm.
  template <class Number>
  Number sensitivity(Number d_mm, Number variance_mm2) const {
    return slope * (step_probability(-d_mm, variance_mm2) -
                    step_probability(-d_mm - reach_mm, variance_mm2 + reach_variance_mm2));
  }
};

}  // namespace firn::droplet
