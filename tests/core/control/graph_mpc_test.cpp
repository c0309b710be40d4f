#include "core/control/graph/graph_mpc.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::graph;
using deposition::Border;

namespace {

const GridSpec kGraphGrid{23, 19, 0.263256, 0.263256, 0.0, 0.0};

std::vector<double> random_values(std::uint64_t seed, std::size_t size, double low, double high) {
  RandomStream random(seed, Purpose::kTest);
  std::vector<double> v(size);
  for (double& x : v) x = random.uniform(low, high);
  return v;
}

std::vector<double> droplets_of(const GraphModel& model) {
  return std::vector<double>(kGraphGrid.size(), model.droplet_mm);
}

double sum_of(std::span<const double> v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return sum;
}

double farthest(std::span<const double> a, std::span<const double> b) {
  double most = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, std::abs(a[n] - b[n]));
  return most;
}

/// Layers along random doses on rough ground, and heights that are wanted.
BoxProblem random_problem(int layers, int steps) {
  const GraphModel model({}, Border::kLose, steps);
  BoxProblem p;
  p.nx = kGraphGrid.nx;
  p.ny = kGraphGrid.ny;
  std::vector<double> surface = random_values(1, kGraphGrid.size(), 0.0, 0.006);
  for (int n = 0; n < layers; ++n)
    p.layers.push_back(layer_along(model, kGraphGrid, droplets_of(model), surface,
                                   random_values(10 + std::uint64_t(n), kGraphGrid.size(), 0.0, 1.0)));
  p.wanted_mm = random_values(2, kGraphGrid.size(), 0.0, 0.008 * layers);
  p.counts.assign(kGraphGrid.size(), 1);
  for (std::size_t c = 0; c < p.counts.size(); ++c) p.counts[c] = c % 11 != 3;
  p.free = p.counts;
  p.effort_mm2 = 0.01 * model.droplet_mm * model.droplet_mm;
  return p;
}

ControlOptions graph_options() {
  ControlOptions o;
  o.scheme = "graph_mpc";
  return o;
}

}  // namespace

TEST_CASE("A single droplet on level ground rises the graph by h1, h2 and h3") {
  const deposition::DropletModel h;
  const GraphModel model(h, Border::kLose, 1);
  std::vector<double> z(kGraphGrid.size(), 0.01), dose(kGraphGrid.size(), 0.0);
  dose[kGraphGrid.index(10, 9)] = 1.0;
  layer_along(model, kGraphGrid, droplets_of(model), z, dose);
  // Ink of a full cell at the border runs off: the one droplet is far from it.
  CHECK(z[kGraphGrid.index(10, 9)] - 0.01 == Approx(h.h1_mm).epsilon(1e-12));
  CHECK(z[kGraphGrid.index(11, 9)] - 0.01 == Approx(h.h2_mm).epsilon(1e-12));
  CHECK(z[kGraphGrid.index(9, 10)] - 0.01 == Approx(h.h3_mm).epsilon(1e-12));
}

TEST_CASE("Flow along the graph conserves volume to 1e-12 between walls") {
  for (const int steps : {1, 8}) {
    const GraphModel model({}, Border::kKeep, steps);
    std::vector<double> z = random_values(3, kGraphGrid.size(), 0.0, 0.05);
    const std::vector<double> dose = random_values(4, kGraphGrid.size(), 0.0, 1.0);
    const double before = sum_of(z);
    layer_along(model, kGraphGrid, droplets_of(model), z, dose);
    CHECK((sum_of(z) - before) / (model.droplet_mm * sum_of(dose)) == Approx(1.0).epsilon(1e-12));
  }
}

TEST_CASE("Flow along the graph takes no node below its cured height") {
  const GraphModel model({}, Border::kLose, 20);
  const std::vector<double> ground = random_values(3, kGraphGrid.size(), 0.0, 0.2);
  std::vector<double> z = ground;
  layer_along(model, kGraphGrid, droplets_of(model), z, random_values(4, kGraphGrid.size(), 0.0, 0.3));
  for (std::size_t c = 0; c < z.size(); ++c) CHECK(z[c] >= ground[c] - 1e-15);
}

TEST_CASE("The affine form of a layer is the layer itself along its plan") {
  const GraphModel model({}, Border::kLose, 5);
  const std::vector<double> ground = random_values(5, kGraphGrid.size(), 0.0, 0.03),
                            dose = random_values(6, kGraphGrid.size(), 0.0, 1.0);
  std::vector<double> exact = ground, affine = ground;
  const AffineLayer layer = layer_along(model, kGraphGrid, droplets_of(model), exact, dose);
  layer.apply(affine, dose);
  CHECK(farthest(exact, affine) < 1e-15);
}

TEST_CASE("Where no limit is met, the affine form is exact for other plans too") {
  const GraphModel model({}, Border::kKeep, 1);
  const std::vector<double> ground = random_values(7, kGraphGrid.size(), 0.0, 0.001),
                            dose = random_values(8, kGraphGrid.size(), 0.8, 1.0),
                            other = random_values(9, kGraphGrid.size(), 0.8, 1.0);
  std::vector<double> along = ground, exact = ground, affine = ground;
  const AffineLayer layer = layer_along(model, kGraphGrid, droplets_of(model), along, dose);
  layer_along(model, kGraphGrid, droplets_of(model), exact, other);
  layer.apply(affine, other);
  CHECK(farthest(exact, affine) < 1e-15);
}

TEST_CASE("The transposed layer passes the dot-product test") {
  const BoxProblem p = random_problem(1, 4);
  const AffineLayer& layer = p.layers.front();
  const std::vector<double> dose = random_values(11, p.cells(), -1.0, 1.0);
  std::vector<double> change(p.cells(), 0.0), lambda = random_values(12, p.cells(), -1.0, 1.0),
                                              by_dose(p.cells());
  layer.change(change, dose);
  double left = 0.0, right = 0.0;
  for (std::size_t c = 0; c < p.cells(); ++c) left += change[c] * lambda[c];
  layer.transposed(lambda, by_dose);
  for (std::size_t c = 0; c < p.cells(); ++c) right += dose[c] * by_dose[c];
  CHECK(left == Approx(right).epsilon(1e-12));
}

TEST_CASE("A layer on a part of the grid changes the same heights") {
  const BoxProblem p = random_problem(1, 3);
  const Window window{4, 15, 3, 14};
  std::vector<double> dose(p.cells(), 0.0), whole(p.cells(), 0.0), part(window.size(), 0.0), dose_of_part;
  dose[kGraphGrid.index(9, 8)] = 1.0;
  for (int j = window.j0; j < window.j1; ++j)
    for (int i = window.i0; i < window.i1; ++i) dose_of_part.push_back(dose[kGraphGrid.index(i, j)]);
  p.layers.front().change(whole, dose);
  p.layers.front().on(window).change(part, dose_of_part);
  for (int j = window.j0; j < window.j1; ++j)
    for (int i = window.i0; i < window.i1; ++i)
      CHECK(part[std::size_t(j - window.j0) * std::size_t(window.nx()) + std::size_t(i - window.i0)] ==
            whole[kGraphGrid.index(i, j)]);
}

TEST_CASE("The plan of all cells together cannot be bettered within its box") {
  const BoxProblem p = random_problem(2, 2);
  const BoxSolution best = solve_together(p, std::vector<double>(p.unknowns(), 0.5), {1e-11, 100'000});
  const double cost = p.cost_mm2(best.doses);
  for (std::size_t n = 0; n < p.unknowns(); n += 7)
    for (const double step : {-1e-3, 1e-3}) {
      if (!p.free[n % p.cells()]) continue;
      std::vector<double> other = best.doses;
      other[n] = std::clamp(other[n] + step, 0.0, 1.0);
      CHECK(p.cost_mm2(other) >= cost * (1.0 - 1e-12));
    }
}

TEST_CASE("Block Jacobi finds the plan of all cells together, to 1e-6 of a droplet") {
  for (const int layers : {1, 3}) {
    const BoxProblem p = random_problem(layers, 1);
    const std::vector<double> start(p.unknowns(), 0.5);
    const BoxSolution together = solve_together(p, start, {1e-10, 100'000}),
                      blocks = solve_in_blocks(p, start, {1e-9, 10'000}, serially);
    CHECK(blocks.iterations > 1);
    CHECK(farthest(together.doses, blocks.doses) < 1e-6);
  }
}

TEST_CASE("Block Jacobi has the same bytes in whatever order its blocks are solved") {
  const BoxProblem p = random_problem(1, 1);
  const std::vector<double> start(p.unknowns(), 0.5);
  const ParallelFor backwards = [](int n, const std::function<void(int)>& body) {
    for (int i = n; i-- > 0;) body(i);
  };
  CHECK(solve_in_blocks(p, start, {}, serially).doses == solve_in_blocks(p, start, {}, backwards).doses);
}

TEST_CASE("graph_mpc asks for as much ink by either solver") {
  const Setup s = cylinder_setup();
  HeightMap h(s.grid);
  h.cells = random_values(13, s.grid.size(), 0.0, 0.004);
  ControlOptions together = graph_options(), blocks = graph_options();
  blocks.extra.texts["graph_solver"] = "blocks";
  const std::int64_t a = make_controller(s, together)->decide({h, 0, 0, 0.0}).drops.total(),
                     b = make_controller(s, blocks)->decide({h, 0, 0, 0.0}).drops.total();
  CHECK(std::abs(a - b) <= 2);  // error diffusion keeps sums, and moves droplets for the least difference
}

TEST_CASE("graph_mpc prints a part under variation as a scheme with feedback does, and ends") {
  const Setup s = cylinder_setup();
  const auto closed = make_controller(s, graph_options());
  const LoopResult r = run_loop(*closed, s, {0.2, 0.001, 0.0, 9, 150});
  CHECK(r.ended);
  CHECK(r.stats.rms_mm < 0.5 * s.model.layer_height_mm());
}

TEST_CASE("graph_mpc plans with the model that it is given") {
  const Setup s = cylinder_setup();
  const auto a = make_controller(s, graph_options()), b = make_controller(s, graph_options());
  HeightMap h(s.grid, s.target.at(20, 20) - 0.004);
  b->use_model(s.model.times(0.6));
  CHECK(b->decide({h, 60, 0, 0.0}).drops.total() > 1.3 * double(a->decide({h, 60, 0, 0.0}).drops.total()));
}

TEST_CASE("graph_mpc refuses a solver that there is not") {
  ControlOptions o = graph_options();
  o.extra.texts["graph_solver"] = "neighbours";
  CHECK_THROWS_WITH(make_controller(cylinder_setup(), o), Catch::Contains("graph_solver"));
}

TEST_CASE("graph_mpc refuses an effort of 0, with which several plans are best") {
  ControlOptions o = graph_options();
  o.extra.numbers["graph_effort"] = 0.0;
  CHECK_THROWS_WITH(make_controller(cylinder_setup(), o), Catch::Contains("graph_effort"));
}
