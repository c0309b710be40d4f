#include "core/exact/exact_math.h"

#include <emmintrin.h>
#include <sleef.h>

// SSE2 is of every x86-64 CPU, and its variants give the bytes of SLEEF's scalar ones in less time.
namespace firn::exact {
namespace {

double low(__m128d both) { return _mm_cvtsd_f64(both); }

}  // namespace

double sin(double x) { return low(Sleef_cinz_sind2_u10sse2(_mm_set1_pd(x))); }
double cos(double x) { return low(Sleef_cinz_cosd2_u10sse2(_mm_set1_pd(x))); }
double tan(double x) { return low(Sleef_cinz_tand2_u10sse2(_mm_set1_pd(x))); }
double atan2(double y, double x) { return low(Sleef_cinz_atan2d2_u10sse2(_mm_set1_pd(y), _mm_set1_pd(x))); }
double cbrt(double x) { return low(Sleef_cinz_cbrtd2_u10sse2(_mm_set1_pd(x))); }

double max_with_cbrt(double least, double x) {
  constexpr double kPlainly = 1.0 - 1e-12;  // the cube's roundings and the root's are 1e-15
  if (!(x >= least * least * least * kPlainly)) return least;
  const double root = cbrt(x);
  return least < root ? root : least;
}

SinCos sincos(double x) {
  const auto both = Sleef_cinz_sincosd2_u10sse2(_mm_set1_pd(x));
  return {low(both.x), low(both.y)};
}

}  // namespace firn::exact
