#include "core/control/mpc/bound.h"

#include <catch2/catch.hpp>

#include "tests/core/control/bound_checker.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

TEST_CASE("no layer of a 4 x 4 part beats the bound, by brute force over 2^16, and the checker proves the same bound") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, false);
    const double best = best_by_brute_force_mm(in);
    const LayerProblem problem(in.setup, in.height, in.materials);
    for (int rows = 2; rows <= 4; ++rows) {
      const LowerBound b = lower_bound(problem, best, {rows, 60, 0.0}, serially);
      INFO("seed " << seed << ", rows " << rows);
      CHECK(b.total_mm <= best + 1e-12);
      if (rows == 4) CHECK(b.total_mm > best - kSinglePrecision_mm);  // one strip: nothing is relaxed
      const double checked = certified_bound_mm(in.height, in.setup.target, in.setup.mask, in.setup.model,
                                                in.setup.border == deposition::Border::kLose, rows, b.multipliers);
      CHECK(checked >= b.total_mm);
      CHECK(checked <= b.total_mm + kSinglePrecision_mm);
    }
  }
}

TEST_CASE("the bound of a larger part rises with the iterations, stays below the best layer found and is proved by the checker") {
  const StripInstance in = random_instance(21, 20, 17, false);
  LayerProblem problem(in.setup, in.height, in.materials);
  for (int rows = 2; rows <= 4; ++rows) sweep_strips(problem, {rows, 50}, serially);
  const double known = by_model_mm(in, problem.drops(in.setup.grid));
  const LowerBound b = lower_bound(problem, known, {2, 150, 0.0}, serially);
  CHECK(b.total_mm <= known);
  CHECK(b.total_mm > b.history_mm.front());
  for (std::size_t i = 1; i < b.history_mm.size(); ++i) CHECK(b.history_mm[i] >= b.history_mm[i - 1]);
  const double checked = certified_bound_mm(in.height, in.setup.target, in.setup.mask, in.setup.model,
                                            in.setup.border == deposition::Border::kLose, 2, b.multipliers);
  CHECK(checked >= b.total_mm);
  CHECK(checked <= known);
}

TEST_CASE("the bound is the same in whatever order its strips are solved, and refuses strips it was not made for") {
  const StripInstance in = random_instance(22, 12, 15, true);
  const LayerProblem problem(in.setup, in.height, in.materials);
  const auto backwards = [](int n, const std::function<void(int)>& body) {
    for (int i = n; i-- > 0;) body(i);
  };
  const LowerBound a = lower_bound(problem, 1.0, {3, 20, 0.0}, serially), b = lower_bound(problem, 1.0, {3, 20, 0.0}, backwards);
  CHECK(a.total_mm == b.total_mm);
  CHECK(a.multipliers == b.multipliers);
  CHECK_THROWS_WITH(lower_bound(problem, 1.0, {1, 20, 0.0}, serially), Catch::Contains("bound rows = 1 is outside 2..4"));
}
