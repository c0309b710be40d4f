#include "core/statistics/distributions.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace firn::statistics {
namespace {

namespace policies = boost::math::policies;
using Policy = policies::policy<policies::domain_error<policies::ignore_error>,      // NaN
                                policies::overflow_error<policies::ignore_error>,    // infinity
                                policies::evaluation_error<policies::ignore_error>,  // best value
                                policies::promote_double<false>>;
using Normal = boost::math::normal_distribution<double, Policy>;
using StudentT = boost::math::students_t_distribution<double, Policy>;

}  // namespace

double normal_cdf(double z) { return boost::math::cdf(Normal(), z); }

double normal_quantile(double p) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!(p > 0.0)) return -kInfinity;
  if (!(p < 1.0)) return kInfinity;
  return boost::math::quantile(Normal(), p);
}

double student_t_cdf(double t, double freedom) { return boost::math::cdf(StudentT(freedom), t); }

double student_t_quantile(double p, double freedom) { return boost::math::quantile(StudentT(freedom), p); }

double student_t_95(double freedom) { return student_t_quantile(0.975, freedom); }

}  // namespace firn::statistics
