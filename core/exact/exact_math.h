// Elementary functions that give the same bytes on every x86-64 CPU. glibc takes variants with fused
// multiply-add where the CPU has it, whose last bit differs; the variants of SLEEF called here never do.
#pragma once

namespace firn::exact {

/// Each is within 1.0 ulp of the true value [Shibata and Petrogalli, IEEE TPDS 31 (2020) 1316]. NaN,
/// infinities and signed zeros as C has them. Angles in rad. A length has sqrt(), which is exact everywhere.
double sin(double x);
double cos(double x);
double tan(double x);
double atan2(double y, double x);
double cbrt(double x);

/// Returns the larger of `least` and cbrt(x), to the last bit: std::max(least, cbrt(x)). The root, which
/// takes as long as ten products, is taken only where it is not plainly the smaller one.
/// @pre `least` is not negative
double max_with_cbrt(double least, double x);

struct SinCos {
  double sin = 0.0, cos = 0.0;
};
SinCos sincos(double x);  ///< both at the cost of one; its last bit is not that of sin() and cos()

}  // namespace firn::exact
