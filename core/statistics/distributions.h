// Distribution functions that intervals and tests need.
#pragma once

namespace firn::statistics {

double normal_cdf(double z);
/// Inverse of normal_cdf, relative error below 1e-12 for p in [1e-300, 1 - 1e-16]; -inf at 0, +inf at 1.
double normal_quantile(double p);
/// Student's t with `freedom` > 0 degrees of freedom.
double student_t_cdf(double t, double freedom);
double student_t_quantile(double p, double freedom);  ///< @pre 0 < p < 1

}  // namespace firn::statistics
