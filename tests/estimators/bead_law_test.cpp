// The law of beads against planted laws at three scales, and recursive against batch least squares.
#include "estimators/bead/bead_law.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::bead;

namespace {

constexpr double kScales[] = {1.0, 0.07, 0.005};  // beads of some mm, ice of 0.1 mm, droplets of some um

// Errors stay from layer to layer (0.6), as in records of walls.
std::vector<Bead> drawn(std::uint64_t seed, const BeadLaw& law, double scatter, int layers = 60,
                        int segments = 40) {
  RandomStream random(seed, Purpose::kInstance, 0, 0);
  std::vector<double> stays(std::size_t(segments), 0.0);
  std::vector<Bead> beads;
  for (int k = 1; k <= layers; ++k) {
    const double nominal = 8.0 * std::exp(0.2 * random.normal());
    for (int s = 0; s < segments; ++s) {
      double& e = stays[std::size_t(s)];
      e = 0.6 * e + 0.8 * scatter * random.normal();
      const double v = nominal * std::exp(0.1 * random.normal());
      beads.push_back({k, std::uint32_t(s), v, law.height_mm(v) * std::exp(e)});
    }
  }
  return beads;
}

}  // namespace

TEST_CASE("Beads without scatter give their law back at any scale") {
  for (const double scale : kScales) {
    const BeadLaw planted{-0.4619, 1.647 + std::log(scale)};
    const BeadFit f = fit_bead_law(drawn(1, planted, 0.0));
    CHECK(f.law.a == Approx(planted.a).epsilon(1e-9));
    CHECK(f.law.b == Approx(planted.b).epsilon(1e-9));
    CHECK(f.scatter < 1e-9);
  }
}

TEST_CASE("Intervals of 95 % of a bead law cover it at least nine times in ten where layers are correlated") {
  const BeadLaw planted{-0.46, 1.65};
  int a = 0, b = 0;
  constexpr int kRecords = 200;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    const BeadFit f = fit_bead_law(drawn(seed, planted, 0.08, 30, 20));
    a += std::abs(f.law.a - planted.a) <= f.a_half_width;
    b += std::abs(f.law.b - planted.b) <= f.b_half_width;
  }
  CHECK(a >= 0.9 * kRecords);
  CHECK(b >= 0.9 * kRecords);
}

TEST_CASE("Recursive least squares from a vague start are the batch's") {
  const std::vector<Bead> beads = drawn(3, {-0.46, 1.65}, 0.08);
  BeadEstimator recursive({0.0, 0.0}, 1e8);
  for (const Bead& b : beads) recursive.add(b.speed_mm_s, b.height_mm);
  const BeadFit batch = fit_bead_law(beads);
  CHECK(recursive.law().a == Approx(batch.law.a).epsilon(1e-4));
  CHECK(recursive.law().b == Approx(batch.law.b).epsilon(1e-4));
}

TEST_CASE("With P = 0.05 I one bead moves the law as r = 1 + x'Px has it") {
  // By hand: v = e, so that x = (1, 1): P x = (0.05, 0.05), r = 1.1, k = P x / r, e = 1.
  BeadEstimator recursive({0.0, 0.0});
  recursive.add(std::exp(1.0), std::exp(1.0));
  CHECK(recursive.law().a == Approx(0.05 / 1.1));
  CHECK(recursive.law().b == Approx(0.05 / 1.1));
}

TEST_CASE("Forgetting follows a law that changes within five layers, and what forgets nothing does not") {
  const BeadLaw before{-0.46, 1.65}, after{-0.3, 1.2};
  BeadEstimator keeps(before), forgets(before, 0.05, 0.97);
  for (BeadEstimator* e : {&keeps, &forgets}) {
    for (const Bead& b : drawn(5, before, 0.02)) e->add(b.speed_mm_s, b.height_mm);
    for (const Bead& b : drawn(6, after, 0.02, 5)) e->add(b.speed_mm_s, b.height_mm);
  }
  const double truth = after.height_mm(8.0);
  CHECK(std::abs(forgets.law().height_mm(8.0) / truth - 1.0) < 0.03);
  CHECK(std::abs(keeps.law().height_mm(8.0) / truth - 1.0) > 0.06);
}

TEST_CASE("Beads that no logarithm has are refused") {
  CHECK_THROWS_WITH(fit_bead_law(std::vector<Bead>{{1, 0, 8, 1}, {1, 1, 8, 1}}), "2 beads; three are needed");
  CHECK_THROWS_WITH(fit_bead_law(std::vector<Bead>{{1, 0, 8, 1}, {1, 1, 8, 0}, {2, 1, 8, 1}}),
                    "a bead's speed or height is not above 0");
}
