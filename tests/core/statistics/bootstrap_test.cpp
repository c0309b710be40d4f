#include "core/statistics/bootstrap.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/distributions.h"

using namespace firn;
using namespace firn::statistics;

namespace {

// How often the 95 % interval of `size` draws covers the true mean.
template <class Draw>
double coverage(std::size_t size, double truth, int studies, Draw draw) {
  RandomStream random(size, Purpose::kTest);
  int covered = 0;
  BootstrapOptions o;
  o.resamples = 999;
  for (int n = 0; n < studies; ++n) {
    std::vector<double> x(size);
    for (double& v : x) v = draw(random);
    o.seed = std::uint64_t(n);
    const Interval i = bootstrap_interval(x, o);
    covered += i.low <= truth && truth <= i.high;
  }
  return double(covered) / studies;
}

double normal(RandomStream& r) { return r.normal(); }
double uniform(RandomStream& r) { return r.uniform(); }
double exponential(RandomStream& r) { return -std::log(1.0 - r.uniform()); }

}  // namespace

TEST_CASE("the bootstrap interval covers a known mean in 95 % of samples, small and skew ones too") {
  const int studies = 1500;  // one sigma of the share: 0.0056
  CHECK(coverage(10, 0.0, studies, normal) == Approx(0.95).margin(0.02));
  CHECK(coverage(20, 0.0, studies, normal) == Approx(0.95).margin(0.018));
  CHECK(coverage(100, 0.0, studies, normal) == Approx(0.95).margin(0.018));
  CHECK(coverage(20, 0.5, studies, uniform) == Approx(0.95).margin(0.02));
  CHECK(coverage(100, 1.0, studies, exponential) == Approx(0.95).margin(0.02));
  CHECK(coverage(30, 1.0, studies, exponential) > 0.92);  // known to fall a little short for strong skew
}

TEST_CASE("for many normal values the bootstrap interval is Student's") {
  RandomStream random(4, Purpose::kTest);
  std::vector<double> x(400);
  for (double& v : x) v = 3.0 + 2.0 * random.normal();
  const double half = student_t_quantile(0.975, 399) * standard_deviation(x) / 20.0;
  const Interval i = bootstrap_interval(x);
  CHECK(i.low == Approx(mean(x) - half).margin(0.06 * half));
  CHECK(i.high == Approx(mean(x) + half).margin(0.06 * half));
}

TEST_CASE("a sample too long to be resampled value by value has Student's interval too") {
  for (const std::size_t size : {1025u, 4097u, 20'001u}) {
    RandomStream random(size, Purpose::kTest);
    std::vector<double> x(size);
    for (double& v : x) v = 3.0 + exponential(random);
    const double half = 1.96 * standard_deviation(x) / std::sqrt(double(size));
    const Interval i = bootstrap_interval(x);
    INFO(size);
    CHECK(i.low == Approx(mean(x) - half).margin(0.1 * half));
    CHECK(i.high == Approx(mean(x) + half).margin(0.1 * half));
  }
}

TEST_CASE("the interval of a skew sample leans to the long side") {
  RandomStream random(8, Purpose::kTest);
  std::vector<double> x(60);
  for (double& v : x) v = std::exp(1.2 * random.normal());
  const Interval i = bootstrap_interval(x);
  CHECK(i.high - mean(x) > 1.15 * (mean(x) - i.low));
}

TEST_CASE("intervals move and stretch with their data, are the same every time, and depend on the seed") {
  RandomStream random(2, Purpose::kTest);
  std::vector<double> x(25), y;
  for (double& v : x) v = random.normal();
  for (const double v : x) y.push_back(10.0 + 2.0 * v);
  const Interval a = bootstrap_interval(x), b = bootstrap_interval(y), again = bootstrap_interval(x);
  CHECK(b.low == Approx(10.0 + 2.0 * a.low));
  CHECK(b.high == Approx(10.0 + 2.0 * a.high));
  CHECK(a.low == again.low);
  CHECK(a.high == again.high);
  BootstrapOptions other;
  other.seed = 2;
  CHECK(bootstrap_interval(x, other).low != a.low);
  other.confidence = 0.5;
  CHECK(bootstrap_interval(x, other).low > a.low);
}

TEST_CASE("what has no spread or no values has an interval that says so") {
  const Interval point = bootstrap_interval(std::vector{2.5, 2.5, 2.5});
  CHECK(point.low == 2.5);
  CHECK(point.high == 2.5);
  CHECK(std::isnan(bootstrap_interval(std::vector{1.0}).low));
  CHECK(std::isnan(mean(std::vector<double>{})));
  CHECK(std::isnan(standard_deviation(std::vector{1.0})));
  CHECK(standard_deviation(std::vector{1.0, 3.0}) == Approx(std::sqrt(2.0)));
}

TEST_CASE("the interval of given values is the same in every build and on every computer") {
  const Interval i = bootstrap_interval(std::vector<double>{1.0, 2.0, 4.0, 8.0, 16.0, 3.5});
  CHECK(i.low == Approx(2.25).epsilon(1e-12));
  CHECK(i.high == Approx(14.0 + 2.0 / 3.0).epsilon(1e-12));
}
