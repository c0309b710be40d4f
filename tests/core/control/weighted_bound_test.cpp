#include "core/control/mpc/bound/weighted_bound.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/layer/weighted_layer.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

double cut_at(const MomentCut& c, double alpha, double m, double s) {
  return c.base + c.slope_m * m - c.square * (m * m + s * s) + (1.0 - alpha) * s;
}

}  // namespace

TEST_CASE("the least of the largest cuts agrees with a fine raster over mean and deviation") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const double alpha = random.uniform(0.1, 0.9), known = 1e-3;
    std::vector<MomentCut> cuts(seed % 5);
    for (MomentCut& c : cuts) {
      const double at = random.uniform(1e-5, 2e-3);
      c.square = 0.5 * (1.0 - alpha) / at;
      c.slope_m = 2.0 * c.square * random.uniform(-1e-3, 1e-3);
      c.base = random.uniform(0.0, 1e-3) + 0.5 * (1.0 - alpha) * at;
    }
    const CutsMinimum least = minimum_of_cuts(cuts, alpha, known, 1e-8);
    double raster = known;
    constexpr int kSide = 600;
    for (int a = 0; a <= kSide; ++a)
      for (int b = 0; b <= kSide; ++b) {
        const double m = known / alpha * (2.0 * a / kSide - 1.0), s = known / (1.0 - alpha) * b / kSide;
        double most = alpha * std::abs(m) + (1.0 - alpha) * s;
        for (const MomentCut& c : cuts) most = std::max(most, cut_at(c, alpha, m, s));
        raster = std::min(raster, most);
      }
    INFO("seed " << seed << ", alpha " << alpha);
    CHECK(least.bound_mm <= raster + 1e-12);
    CHECK(least.bound_mm > raster - 1e-5);
  }
}

TEST_CASE(
    "no layer of a 4 x 4 part has a smaller objective than the bound for its alpha, by brute force over "
    "2^16") {
  double proved = 0.0, best_of_all = 0.0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, seed % 3 == 0);
    RandomStream random(seed, Purpose::kInstance);
    const double alpha = random.uniform(0.05, 0.95);
    LayerProblem tried(in.setup, in.height, in.materials);
    double best = 1e9;
    DropletPattern known(in.setup.grid);
    for (std::uint32_t bits = 0; bits < 1u << 16; ++bits) {  // Gray code: one droplet at a time
      const int c = bits ? __builtin_ctz(bits) : 0;
      if (bits && tried.printable(c % 4, c / 4))
        tried.set_drop(c % 4, c / 4, std::uint8_t(1 - tried.drop(c % 4, c / 4)));
      if (const double value = weighted_objective_mm(tried, alpha); value < best) {
        best = value;
        known = tried.drops(in.setup.grid);
      }
    }
    for (const bool good : {true, false}) {  // from the best layer, and from none
      const WeightedBound b = weighted_bound(in.setup, in.height, in.materials, alpha,
                                             good ? known : DropletPattern(in.setup.grid), {}, serially);
      INFO("seed " << seed << ", alpha " << alpha << (good ? "" : ", from none"));
      CHECK(b.objective_mm <= best + kSinglePrecision_mm);
      CHECK(b.objective_mm <= b.known_mm);
      if (good) {
        proved += b.objective_mm;
        best_of_all += best;
      }
    }
  }
  CHECK(proved >
        0.9 * best_of_all);  // sixteen droplets have few means and deviations: the relaxation costs most here
}

TEST_CASE(
    "the bound for alpha < 1 proves the layer found on a larger part to within two percent, and never "
    "falls") {
  for (std::uint64_t seed = 31; seed <= 33; ++seed) {
    const StripInstance in = random_instance(seed, 24, 20, false);
    RandomStream random(seed, Purpose::kInstance);
    const double alpha = random.uniform(0.3, 0.9);
    LayerProblem problem(in.setup, in.height, in.materials);
    const double found = weighted_layer(problem, alpha, {}, serially);
    const WeightedBound b =
        weighted_bound(in.setup, in.height, in.materials, alpha, problem.drops(in.setup.grid), {}, serially);
    INFO("seed " << seed << ", alpha " << alpha << ": " << b.objective_mm << " to " << found << ", " << b.cuts
                 << " cuts");
    CHECK(b.known_mm == Approx(found).margin(1e-9));
    CHECK(b.objective_mm <= found);
    CHECK(b.objective_mm > 0.98 * found);
    for (std::size_t n = 1; n < b.history_mm.size(); ++n)
      CHECK(b.history_mm[n] >= b.history_mm[n - 1] - 1e-4 * found);
  }
}
