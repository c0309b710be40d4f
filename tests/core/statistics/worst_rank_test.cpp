// Pairs of which some stopped: against ranks by counting, the exact distribution of the rank sum, and printed
// tables.
#include <catch2/catch.hpp>

#include <cmath>
#include <map>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/sign_flip.h"
#include "core/statistics/worst_rank.h"

using namespace firn;
using namespace firn::statistics;

namespace {

// -1, 0, 1: which of two pairs shows the smaller difference, said in words rather than by a key.
int smaller(const PairOutcome& x, const PairOutcome& y) {
  const bool x_stops = x.stops != 0.0, y_stops = y.stops != 0.0;
  if (x_stops != y_stops) return y_stops ? -1 : 1;
  const double a = std::abs(x_stops ? x.stops : x.difference), b = std::abs(y_stops ? y.stops : y.difference);
  return a < b ? -1 : a > b ? 1 : 0;
}

std::vector<double> ranks_by_counting(const std::vector<PairOutcome>& pairs) {
  std::vector<double> ranks;
  for (const PairOutcome& p : pairs) {
    double below = 0.0, equal = 0.0;
    for (const PairOutcome& q : pairs) {
      if (q.stops == 0.0 && q.difference == 0.0) continue;
      below += smaller(q, p) < 0;
      equal += smaller(q, p) == 0;
    }
    const double lead = p.stops != 0.0 ? p.stops : p.difference;
    ranks.push_back(lead == 0.0 ? 0.0 : (lead > 0.0 ? 1.0 : -1.0) * (below + (equal + 1.0) / 2.0));
  }
  return ranks;
}

// The distribution of the sum of the positive ranks under the null hypothesis, rank by rank (no pattern is
// drawn).
double p_by_convolution(const std::vector<double>& ranks) {
  std::map<long, double> chance{{0, 1.0}};
  long found = 0, total = 0;  // doubled: mean ranks are halves
  for (const double r : ranks) {
    const long twice = std::lround(2.0 * std::abs(r));
    std::map<long, double> next;
    for (const auto& [sum, c] : chance) {
      next[sum] += 0.5 * c;
      next[sum + twice] += 0.5 * c;
    }
    chance = std::move(next);
    found += r > 0.0 ? twice : 0;
    total += twice;
  }
  if (total == 0) return 1.0;
  double p = 0.0;
  for (const auto& [sum, c] : chance)
    if (std::abs(2 * sum - total) >= std::abs(2 * found - total)) p += c;
  return p;
}

std::vector<PairOutcome> plain(const std::vector<double>& differences) {
  std::vector<PairOutcome> pairs;
  for (const double d : differences) pairs.push_back({0.0, d});
  return pairs;
}

}  // namespace

TEST_CASE(
    "worst-rank scores are those of counting, and their test that of the rank sum's exact distribution") {
  RandomStream random(21, Purpose::kTest);
  for (int round = 0; round < 200; ++round) {
    std::vector<PairOutcome> pairs;
    for (std::uint32_t k = 0, n = 1 + random.below(14); k < n; ++k) {
      const double stops = random.below(3) == 0 ? double(random.below(5)) - 2.0 : 0.0;
      pairs.push_back({stops, random.below(4) == 0 ? double(random.below(3)) - 1.0
                                                   : random.normal()});  // with ties and zeros
    }
    const std::vector<double> ranks = signed_worst_ranks(pairs);
    REQUIRE(ranks == ranks_by_counting(pairs));
    CHECK(sign_flip_p(ranks) == Approx(p_by_convolution(ranks)).epsilon(1e-12));
    for (PairOutcome& p : pairs) {
      p.stops = -p.stops;
      p.difference = -p.difference;
    }
    const std::vector<double> turned = signed_worst_ranks(pairs);
    for (std::size_t k = 0; k < ranks.size(); ++k) CHECK(turned[k] == -ranks[k]);
  }
}

TEST_CASE("without stops it is Wilcoxon's signed-rank test: its printed critical values") {
  // Two-sided 5 %: n = 8: rank sum 3 (P = 10/256), n = 10: 8 (50/1024), n = 12: 13 (174/4096).
  CHECK(sign_flip_p(signed_worst_ranks(plain({1, 2, -3, 4, 5, 6, 7, 8}))) == Approx(10.0 / 256.0));
  CHECK(sign_flip_p(signed_worst_ranks(plain({1, 2, 3, 4, 5, 6, 7, -8, 9, 10}))) == Approx(50.0 / 1024.0));
  CHECK(sign_flip_p(signed_worst_ranks(plain({-1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, -12}))) ==
        Approx(174.0 / 4096.0));
}

TEST_CASE(
    "stops count: eight seeds of which three stopped tell as much as eight, the complete five alone cannot") {
  std::vector<PairOutcome> pairs = plain({0.7, 0.5, 0.9, 0.6, 0.8});
  CHECK(sign_flip_p(signed_worst_ranks(pairs)) == 2.0 / 32.0);
  for (int k = 0; k < 3; ++k) pairs.push_back({1.0, 0.0});
  CHECK(sign_flip_p(signed_worst_ranks(pairs)) == 2.0 / 256.0);
  pairs.back().stops = -1.0;  // a stop of the other side weighs against more than any value
  CHECK(sign_flip_p(signed_worst_ranks(pairs)) > 0.05);
  CHECK(sign_flip_p(signed_worst_ranks(std::vector<PairOutcome>(4))) == 1.0);
  CHECK(signed_worst_ranks({}).empty());
}

TEST_CASE(
    "the test of worst ranks rejects a true null in 5 % of cases, though stops and errors go together") {
  RandomStream random(33, Purpose::kTest);
  SignFlipOptions quick;
  quick.draws = 999;
  int false_alarms = 0, found = 0, blind = 0;
  const int studies = 1500;
  for (int n = 0; n < studies; ++n) {
    std::vector<PairOutcome> null, worse;
    std::vector<double> complete;
    for (int k = 0; k < 20; ++k) {
      const double day = random.normal();
      const auto value = [&](double shift) { return day + 0.5 * random.normal() + shift; };
      const auto pair = [](double a, double b) {  // runs far out are stopped
        const double stops = double(a > 1.5) - double(b > 1.5);
        return PairOutcome{stops, a > 1.5 || b > 1.5 ? 0.0 : a - b};
      };
      null.push_back(pair(value(0.0), value(0.0)));
      const double b = value(0.0), a = b + (day > 0.0 ? 3.0 : 0.0);  // worse on some days, and then it stops
      worse.push_back(pair(a, b));
      if (worse.back().stops == 0.0) complete.push_back(worse.back().difference);
    }
    quick.seed = std::uint64_t(n);
    false_alarms += sign_flip_p(signed_worst_ranks(null), quick) <= 0.05;
    found += sign_flip_p(signed_worst_ranks(worse), quick) <= 0.05;
    blind += sign_flip_p(complete, quick) > 0.05;
  }
  CHECK(false_alarms / double(studies) < 0.05 + 0.018);  // 3 sigma; ties make it cautious
  CHECK(false_alarms / double(studies) > 0.02);
  CHECK(found / double(studies) > 0.85);
  CHECK(blind == studies);  // the complete pairs alone show nothing
}
