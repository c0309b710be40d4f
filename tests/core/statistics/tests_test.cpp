#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/comparison.h"
#include "core/statistics/distributions.h"
#include "core/statistics/holm.h"
#include "core/statistics/sign_flip.h"

using namespace firn;
using namespace firn::statistics;

TEST_CASE("Holm's adjustment of hand-worked families") {
  // 0.01 x 4; then 0.02 x 3 = 0.06; 0.03 x 2 = 0.06; 0.04 x 1 = 0.04, held at 0.06.
  CHECK(holm(std::vector{0.01, 0.04, 0.03, 0.02}) == std::vector{0.04, 0.06, 0.06, 0.06});
  CHECK(holm(std::vector{0.5, 0.6}) == std::vector{1.0, 1.0});
  CHECK(holm(std::vector{0.2}) == std::vector{0.2});
  CHECK(holm(std::vector<double>{}).empty());
  const auto equal = holm(std::vector{0.01, 0.01, 0.01});
  for (const double p : equal) CHECK(p == Approx(0.03));
}

TEST_CASE("Holm never adjusts downward, keeps the order, and rejects at least what Bonferroni rejects") {
  RandomStream random(3, Purpose::kTest);
  for (int n = 0; n < 300; ++n) {
    std::vector<double> p(1 + random.below(12));
    for (double& v : p) v = random.uniform() * random.uniform();
    const auto q = holm(p);
    for (std::size_t a = 0; a < p.size(); ++a) {
      CHECK(q[a] >= p[a]);
      CHECK(q[a] <= std::min(1.0, double(p.size()) * p[a]) + 1e-15);
      for (std::size_t b = 0; b < p.size(); ++b)
        if (p[a] < p[b]) CHECK(q[a] <= q[b]);
    }
  }
}

TEST_CASE("with all hypotheses true, Holm's family errs in no more than 5 % of studies") {
  RandomStream random(17, Purpose::kTest);
  int wrong = 0;
  for (int study = 0; study < 4000; ++study) {
    std::vector<double> p(10);
    for (double& v : p) v = random.uniform();
    const auto q = holm(p);
    wrong += *std::min_element(q.begin(), q.end()) <= 0.05;
  }
  CHECK(wrong / 4000.0 < 0.06);
  CHECK(wrong / 4000.0 > 0.035);
}

TEST_CASE("the sign-flip test counts patterns as the definition does") {
  CHECK(sign_flip_p(std::vector{1.0, 2.0, 3.0}) == 2.0 / 8.0);  // only +++ and --- reach 6
  CHECK(sign_flip_p(std::vector{1.0, 2.0, -3.0}) == 1.0);       // the sum is 0
  CHECK(sign_flip_p(std::vector{-1.0, 2.0, 3.0, 4.0}) ==
        4.0 / 16.0);  // 8 is reached by all + (10), this, and mirrored
  CHECK(sign_flip_p(std::vector{0.0, 0.0}) == 1.0);
  CHECK(sign_flip_p(std::vector<double>{}) == 1.0);
  CHECK(smallest_p(5) == 2.0 / 32.0);
  RandomStream random(5, Purpose::kTest);
  for (int n = 0; n < 40; ++n) {  // brute force over all masks
    std::vector<double> d(1 + random.below(10));
    for (double& v : d) v = double(random.below(7)) - 2.5;
    double found = 0.0;
    for (const double v : d) found += v;
    int hits = 0;
    for (unsigned mask = 0; mask < 1u << d.size(); ++mask) {
      double s = 0.0;
      for (std::size_t k = 0; k < d.size(); ++k) s += mask >> k & 1u ? -d[k] : d[k];
      hits += std::abs(s) >= std::abs(found) - 1e-9;
    }
    CHECK(sign_flip_p(d) == double(hits) / double(1u << d.size()));
  }
}

TEST_CASE("random sign patterns agree with all of them") {
  RandomStream random(6, Purpose::kTest);
  for (int n = 0; n < 10; ++n) {
    std::vector<double> d(14);
    for (double& v : d) v = random.normal() + 0.3;
    SignFlipOptions drawn;
    drawn.all_up_to = 0;
    CHECK(sign_flip_p(d, drawn) == Approx(sign_flip_p(d)).margin(0.012));  // 3 sigma at 20,000 draws
  }
}

TEST_CASE("differences whose sum is 0 have the p-value 1, by all patterns and by drawn ones") {
  const std::vector<double> d{1.0, 2.0, -3.0, 0.5, -0.5};
  SignFlipOptions drawn;
  drawn.all_up_to = 0;
  CHECK(sign_flip_p(d) == 1.0);
  CHECK(sign_flip_p(d, drawn) == 1.0);
}

TEST_CASE("the sign-flip test rejects a true null in 5 % of cases, and finds a planted difference") {
  RandomStream random(9, Purpose::kTest);
  SignFlipOptions quick;
  quick.draws = 999;
  int false_alarms = 0, found = 0;
  const int studies = 1500;
  for (int n = 0; n < studies; ++n) {
    std::vector<double> null(30), shifted(30);
    for (std::size_t k = 0; k < 30; ++k) {
      const double u = random.uniform();  // skew in each sample, symmetric in the difference
      null[k] = -std::log(1.0 - u) + std::log(1.0 - random.uniform());
      shifted[k] = random.normal() + 0.7;
    }
    quick.seed = std::uint64_t(n);
    false_alarms += sign_flip_p(null, quick) <= 0.05;
    found += sign_flip_p(shifted, quick) <= 0.05;
  }
  CHECK(false_alarms / double(studies) == Approx(0.05).margin(0.018));  // 3 sigma
  CHECK(found / double(studies) > 0.93);                                // power of the t test here: 0.96
}

TEST_CASE("a paired comparison sees through what the pairs have in common") {
  RandomStream random(12, Purpose::kTest);
  std::vector<double> a(40), b(40), shuffled(40);
  for (std::size_t k = 0; k < 40; ++k) {
    const double common = 5.0 * random.normal();  // both prints of a pair meet the same nature
    a[k] = common + 0.1 * random.normal();
    b[k] = common + 0.1 * random.normal() + 0.2;
  }
  for (std::size_t k = 0; k < 40; ++k) shuffled[k] = b[(k + 17) % 40];
  const PairedComparison paired = compare_pairs(a, b), unpaired = compare_pairs(a, shuffled);
  CHECK(paired.p < 0.001);
  CHECK(paired.interval.low > -0.3);
  CHECK(paired.interval.high < -0.1);
  CHECK(unpaired.p > 0.2);
  CHECK(paired.a_below_b > 0.8);
  CHECK(paired.effect < -1.0);
  CHECK(paired.difference == Approx(paired.mean_a - paired.mean_b));
}

TEST_CASE(
    "a sample compared with itself, and one shifted by a constant, are told without a division by zero") {
  const std::vector<double> a{1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  std::vector<double> b = a;
  const PairedComparison same = compare_pairs(a, b);
  CHECK(same.p == 1.0);
  CHECK(same.effect == 0.0);
  CHECK(same.interval.low == 0.0);
  CHECK(same.interval.high == 0.0);
  CHECK(same.a_below_b == 0.5);
  for (double& v : b) v += 0.5;
  const PairedComparison shifted = compare_pairs(a, b);
  CHECK(shifted.p == smallest_p(6));
  CHECK(std::isinf(shifted.effect));
  CHECK(shifted.interval.low == -0.5);
}

TEST_CASE("the sign-flip p of a long sample is the normal distribution's") {
  for (const std::size_t size : {3000u, 50'001u})
    for (const double z : {0.5, 1.5, 2.5}) {
      RandomStream random(size, Purpose::kTest);
      std::vector<double> d(size);
      for (double& v : d) v = random.normal();
      const double now = mean(d), wanted = z * standard_deviation(d) / std::sqrt(double(size));
      for (double& v : d) v += wanted - now;
      INFO(size << " values, z " << z);
      CHECK(sign_flip_p(d) == Approx(2.0 * normal_cdf(-z)).epsilon(0.35));
    }
}
