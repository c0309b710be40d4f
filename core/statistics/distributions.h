// Computes distribution functions for intervals and tests, by Boost.Math. Last digits may differ between
// versions of Boost: a node must not decide by them.
#pragma once

namespace firn::statistics {

double normal_cdf(double z);
/// Inverse of normal_cdf; -inf at 0, +inf at 1.
double normal_quantile(double p);
/// Student's t with `freedom` > 0 degrees of freedom.
double student_t_cdf(double t, double freedom);
double student_t_quantile(double p, double freedom);  ///< @pre 0 < p < 1
/// The factor t with P(|T| < t) = 0.95, for 95 % intervals.
double student_t_95(double freedom);

}  // namespace firn::statistics
