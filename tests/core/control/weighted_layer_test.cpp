#include "core/control/mpc/layer/weighted_layer.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "core/control/mpc/mpc.h"
#include "core/control/prediction.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

// Eq. (8) by the height-change model itself [mm].
double by_model(const StripInstance& in, const DropletPattern& u, double alpha) {
  HeightMap h = in.height;
  deposition::HeightChange<1>(in.setup.grid, deposition::stencil_of(in.setup.model), in.setup.border)
      .step(h.data(), u.data(), 0);
  return objective_mm(h, in.setup.target, in.setup.mask, alpha);
}

}  // namespace

TEST_CASE(
    "strips lower any sum of |e|, e and e^2 exactly: a strip as high as the grid against brute force on 4 x "
    "4") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, seed % 3 == 0);
    RandomStream random(seed, Purpose::kInstance);
    const CellCost cost{float(random.uniform(0.0, 1.0)), float(random.uniform(-0.5, 0.5)),
                        float(random.uniform(0.0, 300.0))};
    LayerProblem tried(in.setup, in.height, in.materials);
    double best = 1e9;
    for (std::uint32_t bits = 0; bits < 1u << 16; ++bits) {  // Gray code: one droplet at a time
      const int c = bits ? __builtin_ctz(bits) : 0;
      if (bits && tried.printable(c % 4, c / 4))
        tried.set_drop(c % 4, c / 4, std::uint8_t(1 - tried.drop(c % 4, c / 4)));
      best = std::min(best, total_cost(tried, cost));
    }
    LayerProblem problem(in.setup, in.height, in.materials);
    sweep_strips(problem, {4, 1, cost}, serially);
    CHECK(total_cost(problem, cost) < best + 1e-5);
    LayerProblem split(in.setup, in.height, in.materials);
    const LayerSolution s = solve_layer(
        split, {.polish_rows = 2, .bound_rows = 1, .sweeps = 6, .gap = 0.0, .cost = cost}, serially);
    CHECK(s.found_mm < best + 1e-5);
    CHECK(s.lower_bound_mm < best + 1e-5);
  }
}

TEST_CASE(
    "a layer for alpha < 1 is never worse than none, all or the start, and on the average better than the "
    "greedy search's") {
  double strips = 0.0, greedy = 0.0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    const StripInstance in = random_instance(seed, 18, 16, false);
    RandomStream random(seed, Purpose::kInstance);
    const double alpha = random.uniform(0.05, 1.0);
    const DropletPattern start = random_drops(in, random);
    LayerProblem problem(in.setup, in.height, in.materials);
    problem.set_drops(start);
    const double found = weighted_layer(problem, alpha, {}, serially);
    INFO("seed " << seed << ", alpha " << alpha);
    CHECK(found == Approx(by_model(in, problem.drops(in.setup.grid), alpha)).margin(1e-7));
    DropletPattern all(in.setup.grid);
    for (std::size_t c = 0; c < all.size(); ++c) all.cells[c] = in.setup.mask.cells[c];
    for (const DropletPattern& u : {start, all, DropletPattern(in.setup.grid)})
      CHECK(found <= by_model(in, u, alpha) + 1e-7);
    HorizonObjective search(in.setup, 1, 1);
    search.set_surface(in.height, alpha);
    search.set_plan(std::vector<DropletPattern>(1, all));
    RandomStream stream(seed, Purpose::kGreedySearch);
    greedy_search(search, {16, 1'000'000}, stream);
    strips += found;
    greedy += search.value_mm();
  }
  CHECK(strips < 0.995 * greedy);
}

TEST_CASE(
    "MPC method certified: on each state no worse than printing nothing, and on the average no worse than "
    "strips") {
  double certified = 0.0, strips = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const StripInstance in = random_instance(seed, 16, 15, false);
    RandomStream random(seed, Purpose::kInstance);
    ControlOptions o;
    o.noise_gate = 0.0;
    o.mpc.alpha = {{1, seed % 2 ? 1.0 : random.uniform(0.3, 1.0)}};
    for (const MpcMethod method : {MpcMethod::kCertified, MpcMethod::kStripDp}) {
      o.mpc.method = method;
      const Decision d = Mpc(in.setup, o).decide({in.height, 0, 0, 0.0});
      const double none = objective_mm(in.height, in.setup.target, in.setup.mask, o.mpc.alpha[0].alpha);
      CHECK(d.objective_none_mm == Approx(none));
      CHECK(d.objective_mm <= none + 1e-12);
      if (d.kind == Decision::Kind::kPrint)
        CHECK(d.objective_mm == Approx(by_model(in, d.drops, o.mpc.alpha[0].alpha)).margin(1e-9));
      (method == MpcMethod::kCertified ? certified : strips) += d.objective_mm;
    }
  }
  CHECK(certified <= strips);
}
