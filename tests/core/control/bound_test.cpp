#include "core/control/mpc/bound/bound.h"

#include <catch2/catch.hpp>

#include "core/control/mpc/bound/bound_checker.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

void backwards(int n, const std::function<void(int)>& body) {
  for (int i = n; i-- > 0;) body(i);
}

}  // namespace

TEST_CASE(
    "no layer of a 4 x 4 part beats the bound, by brute force over 2^16, and the solver finds the best one") {
  int proved = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, seed % 3 == 0);
    const double best = best_by_brute_force_mm(in);
    for (int rows = 1; rows <= 4; ++rows) {
      const LowerBound b = lower_bound(in.setup, in.height, in.materials, best, {rows, 40, 0.0}, serially);
      INFO("seed " << seed << ", rows " << rows);
      CHECK(b.total_mm <= best + 1e-12);
      if (rows == 4) CHECK(b.total_mm > best - 1e-12);  // one strip: nothing is relaxed
      proved += b.total_mm > best - kSinglePrecision_mm;
      CHECK(std::abs(b.total_mm - b.history_mm.back()) < kSinglePrecision_mm);
    }
    LayerProblem problem(in.setup, in.height, in.materials);
    solve_layer(problem, {}, serially);
    CHECK(by_model_mm(in, problem.drops(in.setup.grid)) < best + kSinglePrecision_mm);
  }
  CHECK(proved >= 44);  // of 48: the relaxation is mostly tight
}

TEST_CASE("any multipliers prove a bound: random ones too stay below the best layer of a 4 x 4 part") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, false);
    const double best = best_by_brute_force_mm(in);
    RandomStream random(seed, Purpose::kInstance);
    std::vector<float> multipliers(3 * 4 * kSharedPatterns);
    for (float& v : multipliers) v = float(random.uniform(-1e-3, 1e-3));
    const double proved = certified_bound_mm(in.setup, in.height, in.materials, 1, multipliers);
    CHECK(proved <= best + 1e-12);
    CHECK(proved < certified_bound_mm(in.setup, in.height, in.materials, 4, {}));
  }
}

TEST_CASE(
    "the bound of a larger part never falls from sweep to sweep and stays below the layer found, within half "
    "a percent") {
  for (std::uint64_t seed = 21; seed <= 24; ++seed) {
    const StripInstance in = random_instance(seed, 20, 17, seed % 2 == 0);
    LayerProblem problem(in.setup, in.height, in.materials);
    const LayerSolution found = solve_layer(problem, {3, 1, 8, 0.0}, serially);
    const double known = by_model_mm(in, problem.drops(in.setup.grid));
    CHECK(std::abs(found.found_mm - known) < 1e-6);
    const LowerBound b = lower_bound(in.setup, in.height, in.materials, known, {2, 12, 0.0}, serially);
    CHECK(b.total_mm <= known + 1e-12);
    CHECK(b.total_mm > 0.995 * known);
    for (std::size_t i = 1; i < b.history_mm.size(); ++i)
      CHECK(b.history_mm[i] >= b.history_mm[i - 1] - 1e-6);
  }
}

TEST_CASE(
    "patches of another layer are taken where they are better: never worse than either, and equal where "
    "alike") {
  const StripInstance in = random_instance(31, 40, 40, false);
  RandomStream random(31, Purpose::kInstance);
  LayerProblem a(in.setup, in.height, in.materials), b = a;
  a.set_drops(random_drops(in, random));
  sweep_strips(a, {1, 100}, serially);
  DropletPattern u = a.drops(in.setup.grid);
  for (const int cell : {205, 830, 1411})
    u.cells[std::size_t(cell)] ^= in.setup.mask.cells[std::size_t(cell)];
  b.set_drops(u);
  sweep_strips(b, {2, 100}, serially);
  const double best = std::min(a.total_mm(), b.total_mm());
  const double worse = a.total_mm();
  const int taken = take_better_patches(a, b);
  CHECK(taken > 0);
  CHECK(a.total_mm() < worse);
  CHECK(a.total_mm() < best + 1e-6);
  CHECK(take_better_patches(a, a) == 0);
}

TEST_CASE(
    "bound and layer are the same in whatever order strips that run together are solved, and other rows are "
    "refused") {
  const StripInstance in = random_instance(22, 9, 200, true);  // several groups of strips
  const LowerBound a = lower_bound(in.setup, in.height, in.materials, 0.0, {1, 4, 0.0}, serially);
  const LowerBound b = lower_bound(in.setup, in.height, in.materials, 0.0, {1, 4, 0.0}, backwards);
  CHECK(a.total_mm == b.total_mm);
  CHECK(a.multipliers == b.multipliers);
  LayerProblem p(in.setup, in.height, in.materials), q = p;
  CHECK(solve_layer(p, {}, serially).found_mm == solve_layer(q, {}, backwards).found_mm);
  CHECK(p.drops(in.setup.grid) == q.drops(in.setup.grid));
  for (const int rows : {0, 5})
    CHECK_THROWS_WITH(lower_bound(in.setup, in.height, in.materials, 1.0, {rows, 20, 0.0}, serially),
                      Catch::Contains("is outside 1..4"));
}
