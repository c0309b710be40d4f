#include "core/statistics/distributions.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace firn::statistics;

TEST_CASE("normal and t quantiles are those of the printed tables") {
  CHECK(normal_quantile(0.975) == Approx(1.959963984540054).epsilon(1e-12));
  CHECK(normal_quantile(0.5) == Approx(0.0).margin(1e-12));
  CHECK(normal_quantile(1e-6) == Approx(-4.753424308822899).epsilon(1e-10));
  CHECK(std::isinf(normal_quantile(0.0)));
  // 97.5 % points of Student's t.
  for (const auto& [freedom, t] : {std::pair{1.0, 12.7062047364},
                                   {2.0, 4.30265272975},
                                   {5.0, 2.57058183661},
                                   {9.0, 2.26215716274},
                                   {30.0, 2.04227245630},
                                   {99.0, 1.98421695159}})
    CHECK(student_t_quantile(0.975, freedom) == Approx(t).epsilon(1e-8));
}

TEST_CASE("t with one and with two degrees of freedom has its closed form") {
  for (double t = -30.0; t <= 30.0; t += 0.37) {
    CHECK(student_t_cdf(t, 1.0) ==
          Approx(0.5 + std::atan(t) / 3.14159265358979324).epsilon(1e-9).margin(1e-12));
    CHECK(student_t_cdf(t, 2.0) ==
          Approx(0.5 + t / (2.0 * std::sqrt(2.0 + t * t))).epsilon(1e-9).margin(1e-12));
  }
}

TEST_CASE("quantiles undo distribution functions, and many degrees of freedom are the normal") {
  for (double p = 0.001; p < 1.0; p += 0.013) {
    CHECK(normal_cdf(normal_quantile(p)) == Approx(p).epsilon(1e-11));
    CHECK(student_t_cdf(student_t_quantile(p, 7.0), 7.0) == Approx(p).epsilon(1e-10));
    CHECK(student_t_quantile(p, 1e6) == Approx(normal_quantile(p)).epsilon(1e-4).margin(1e-4));
  }
}
