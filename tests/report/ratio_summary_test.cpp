#include "report/study/ratio_summary.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::report;

namespace {

std::vector<double> drawn_logs(std::uint64_t key, std::size_t n, double mean, double sd) {
  RandomStream random(key, Purpose::kTest);
  std::vector<double> x(n);
  for (double& v : x) v = mean + sd * random.normal();
  return x;
}

}  // namespace

TEST_CASE("Ratios are averaged as logarithms: twice and half are none") {
  CHECK(ratio_of(std::vector<double>{std::log(2.0), std::log(0.5)}).ratio == Approx(1.0));
}

TEST_CASE("A ratio of 0.7 is found, and its interval lies about it") {
  const RatioSummary s = ratio_of(drawn_logs(1, 80, std::log(0.7), 0.2));
  CHECK(s.interval.low < 0.7);
  CHECK(s.interval.high > 0.7);
  CHECK(s.p < 0.001);
}

TEST_CASE("The one-sided bound of a ratio lies within the two-sided interval") {
  const RatioSummary s = ratio_of(drawn_logs(2, 40, 0.0, 0.2));
  CHECK(s.upper > s.ratio);
  CHECK(s.upper < s.interval.high);
}

TEST_CASE("Of schemes that are alike 80 labs show that none is more than 10 % worse") {
  int held = 0;
  for (std::uint64_t key = 1; key <= 60; ++key)
    held += ratio_of(drawn_logs(key, 80, 0.0, 0.15)).upper <= 1.10;
  CHECK(held >= 58);  // 99.99 % each
}

TEST_CASE("A ratio of exactly the margin passes in some 5 % of studies") {
  int held = 0;
  for (std::uint64_t key = 1; key <= 200; ++key)
    held += ratio_of(drawn_logs(key, 80, std::log(1.10), 0.15), {0.95, 2000}).upper <= 1.10;
  CHECK(held <= 20);  // 10 are expected, with a standard deviation of 3
}
