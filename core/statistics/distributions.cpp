#include "core/statistics/distributions.h"

#include <cmath>
#include <initializer_list>
#include <limits>

namespace firn::statistics {
namespace {

// Continued fraction of the incomplete beta function, evaluated by Lentz's method [Numerical Recipes, 6.4].
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  double c = 1.0, d = 1.0 - (a + b) * x / (a + 1.0);
  d = 1.0 / (std::abs(d) < kTiny ? kTiny : d);
  double h = d;
  for (int m = 1; m <= 300; ++m) {
    for (const double step : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                              -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1.0 + step * d;
      d = 1.0 / (std::abs(d) < kTiny ? kTiny : d);
      c = 1.0 + step / c;
      if (std::abs(c) < kTiny) c = kTiny;
      h *= d * c;
    }
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return h;
}

double log_gamma(double x) {  // std::lgamma writes a global; Lanczos' series [Numerical Recipes, 6.1]
  constexpr double kTerms[] = {76.18009172947146,  -86.50532032941677,    24.01409824083091,
                               -1.231739572450155, 0.1208650973866179e-2, -0.5395239384953e-5};
  double sum = 1.000000000190015, y = x;
  for (const double term : kTerms) sum += term / ++y;
  return std::log(2.5066282746310005 * sum / x) - (x + 5.5) + (x + 0.5) * std::log(x + 5.5);
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  const double front =
      std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1.0) / (a + b + 2.0) ? front * beta_fraction(a, b, x) / a
                                       : 1.0 - front * beta_fraction(b, a, 1.0 - x) / b;
}

}  // namespace

double normal_cdf(double z) { return 0.5 * std::erfc(-z * 0.70710678118654752440); }

double normal_quantile(double p) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!(p > 0.0)) return -kInfinity;
  if (!(p < 1.0)) return kInfinity;
  if (p > 0.5) return -normal_quantile(1.0 - p);
  // A rough start [Abramowitz and Stegun 26.2.23], then Halley's steps on the distribution function.
  const double t = std::sqrt(-2.0 * std::log(p));
  double z = -(t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                       (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308))));
  for (int n = 0; n < 4; ++n) {
    const double density = std::exp(-0.5 * z * z) * 0.39894228040143267794;
    if (!(density > 0.0)) break;
    const double u = (normal_cdf(z) - p) / density;
    z -= u / (1.0 + 0.5 * z * u);
  }
  return z;
}

double student_t_cdf(double t, double freedom) {
  const double tail = 0.5 * incomplete_beta(0.5 * freedom, 0.5, freedom / (freedom + t * t));
  return t > 0.0 ? 1.0 - tail : tail;
}

double student_t_quantile(double p, double freedom) {
  if (p > 0.5) return -student_t_quantile(1.0 - p, freedom);
  double low = -1.0, high = 0.0;
  while (student_t_cdf(low, freedom) > p) low *= 2.0;
  for (int n = 0; n < 200 && high - low > 1e-14 * -low; ++n) {
    const double middle = 0.5 * (low + high);
    (student_t_cdf(middle, freedom) > p ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace firn::statistics
