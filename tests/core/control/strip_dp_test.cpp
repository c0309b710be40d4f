#include "core/control/mpc/layer/strip_dp.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/mpc.h"
#include "core/control/prediction.h"
#include "core/grid/random.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

TEST_CASE(
    "the layer problem's errors are those of the height-change model, droplet by droplet and all at once") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const StripInstance in = random_instance(seed, 7, 6, seed % 2);
    RandomStream random(seed, Purpose::kInstance);
    LayerProblem problem(in.setup, in.height, in.materials);
    const DropletPattern u = random_drops(in, random);
    problem.set_drops(u);
    REQUIRE(std::abs(problem.total_mm() - by_model_mm(in, u)) < kSinglePrecision_mm);
    const DropletPattern v = random_drops(in, random);
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 7; ++i) problem.set_drop(i, j, v.at(i, j));
    REQUIRE(std::abs(problem.total_mm() - by_model_mm(in, v)) < kSinglePrecision_mm);
    REQUIRE(problem.drops(in.setup.grid) == v);
  }
}

TEST_CASE("a row of effects holds each cell's effect") {
  const StripInstance in = random_instance(3, 9, 5, false);
  const LayerProblem problem(in.setup, in.height, in.materials);
  std::vector<float> row(9 * 9);
  for (int j = 0; j < 5; ++j) {
    problem.effects(j, row.data());
    for (int i = 0; i < 9; ++i)
      for (int q = 0; q < 9; ++q) CHECK(row[std::size_t(q * 9 + i)] == problem.effect(i, j)[std::size_t(q)]);
  }
}

TEST_CASE("a strip as high as the grid gives the best layer of all: brute force over 2^16 on 4 x 4") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, seed % 3 == 0);
    const double best = best_by_brute_force_mm(in);
    LayerProblem problem(in.setup, in.height, in.materials);
    CHECK(sweep_strips(problem, {4, 1}, serially).strips == 1);
    CHECK(by_model_mm(in, problem.drops(in.setup.grid)) < best + kSinglePrecision_mm);
  }
}

TEST_CASE("strips never raise the objective, wider ones least of all, and leave cells off the mask empty") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const StripInstance in = random_instance(seed, 17, 13, seed % 2);
    RandomStream random(seed, Purpose::kInstance);
    LayerProblem problem(in.setup, in.height, in.materials);
    problem.set_drops(random_drops(in, random));
    double before = by_model_mm(in, problem.drops(in.setup.grid));
    for (int rows = 1; rows <= 4; ++rows) {
      CHECK(sweep_strips(problem, {rows, 100}, serially).settled);
      const DropletPattern u = problem.drops(in.setup.grid);
      const double now = by_model_mm(in, u);
      CHECK(now <= before + kSinglePrecision_mm);
      before = now;
      for (std::size_t c = 0; c < u.size(); ++c)
        if (!in.setup.mask.cells[c]) REQUIRE(u.cells[c] == 0);
    }
  }
}

TEST_CASE("strips give the same bytes in whatever order those that may run together are run") {
  const StripInstance in = random_instance(5, 60, 90, false);
  const auto backwards = [](int n, const std::function<void(int)>& body) {
    for (int i = n; i-- > 0;) body(i);
  };
  LayerProblem a(in.setup, in.height, in.materials), b = a;
  for (int rows = 2; rows <= 3; ++rows) {
    sweep_strips(a, {rows, 20}, serially);
    sweep_strips(b, {rows, 20}, backwards);
  }
  CHECK(a.drops(in.setup.grid) == b.drops(in.setup.grid));
  for (int j = 0; j < 90; ++j)
    for (int i = 0; i < 60; ++i) REQUIRE(a.error_mm(i, j) == b.error_mm(i, j));
}

TEST_CASE("two-row strips recover a printed layer exactly, however far droplets spread") {
  for (const double spread : {0.136, 0.3, 0.5, 0.8, 1.0})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const GridSpec g{20, 20};
      RandomStream random(seed, Purpose::kInstance);
      StripInstance in{{g, HeightMap(g), Mask(g, 1), {}, deposition::Border::kLose, seed}, HeightMap(g), {}};
      in.setup.model.h2_mm = spread * in.setup.model.h1_mm;
      in.setup.model.h3_mm = in.setup.model.h2_mm / 3.0;
      DropletPattern printed(g);
      for (std::size_t c = 0; c < g.size(); ++c) {
        in.height.cells[c] = random.uniform(0.0, 0.05);
        printed.cells[c] = std::uint8_t(random.below(2));
      }
      in.setup.target = in.height;
      deposition::HeightChange<1>(g, deposition::stencil_of(in.setup.model), in.setup.border)
          .deposit(in.setup.target, printed);
      LayerProblem problem(in.setup, in.height, {});
      sweep_strips(problem, {2, 100}, serially);
      INFO("h2/h1 = " << spread << ", seed " << seed);
      CHECK(problem.drops(g) == printed);
    }
}

TEST_CASE("strips of 0 or 7 rows are refused, and a grid lower than a strip is one strip") {
  const StripInstance in = random_instance(8, 5, 3, false);
  LayerProblem problem(in.setup, in.height, in.materials);
  CHECK_THROWS_WITH(sweep_strips(problem, {0, 1}, serially),
                    Catch::Contains("strip rows = 0 is outside 1..6"));
  CHECK_THROWS_AS(sweep_strips(problem, {7, 1}, serially), std::invalid_argument);
  CHECK(sweep_strips(problem, {6, 1}, serially).strips == 1);
}

TEST_CASE(
    "MPC by strips: never worse than printing nothing for any alpha and horizon, and at alpha = 1 better "
    "than greedy on the average") {
  double greedy_sum = 0.0, strips_sum = 0.0;
  RandomStream random(11, Purpose::kTest);
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const StripInstance in = random_instance(seed, 16, 15, false);
    ControlOptions o;
    o.noise_gate = 0.0;
    o.mpc.horizon = seed % 4 == 0 ? 2 : 1;
    if (seed % 2 == 0) o.mpc.alpha = {{1, random.uniform(0.1, 1.0)}};
    const double none = objective_mm(in.height, in.setup.target, in.setup.mask, o.mpc.alpha[0].alpha);
    for (const MpcMethod method : {MpcMethod::kGreedy, MpcMethod::kStripDp}) {
      o.mpc.method = method;
      const Decision d = Mpc(in.setup, o).decide({in.height, 0, 0, 0.0});
      INFO("seed " << seed);
      CHECK(d.objective_mm <= none + 1e-12);
      if (seed % 2 == 1) (method == MpcMethod::kGreedy ? greedy_sum : strips_sum) += d.objective_mm;
    }
  }
  CHECK(strips_sum < 0.99 * greedy_sum);
}
