// Ink beside the part in the objective of MPC: against the height-change model itself, and against all layers
// and plans there are on grids small enough to try them all.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/bound/bound_checker.h"
#include "core/control/mpc/delta_cache.h"
#include "core/control/mpc/edge_reference.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/one_layer.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "core/control/mpc/mpc.h"
#include "core/deposition/two_materials.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

constexpr double kOutsideRounding_mm = 1e-12;

struct Outcome {
  double error_mm = 0.0, squares_mm2 = 0.0, outside_mm = 0.0;
};

// The surface after layers of one ink each, by the model alone: ink that leaves the grid's border is beside
// the part too.
Outcome by_model(const StripInstance& in, std::span<const DropletPattern> layers) {
  deposition::TwoMaterialChange model(in.setup.grid, {in.setup.model, in.setup.model_b}, in.setup.border);
  MaterialMap inks = in.materials;
  if (inks.size() == 0) {
    inks = MaterialMap(in.setup.grid);
    for (auto& m : inks.cells) m = std::uint8_t(Material::kA);
  }
  HeightMap h = in.height;
  Outcome out;
  for (const DropletPattern& u : layers) out.outside_mm += model.deposit(h, u, inks).lost_mm;
  for (std::size_t c = 0; c < h.size(); ++c) {
    const double e = h.cells[c] - in.setup.target.cells[c];
    if (!in.setup.mask.cells[c]) {
      out.outside_mm += h.cells[c] - in.height.cells[c];
      continue;
    }
    out.error_mm += std::abs(e);
    out.squares_mm2 += e * e;
  }
  return out;
}

double cost_mm(const StripInstance& in, const DropletPattern& u, double price) {
  const Outcome o = by_model(in, std::span(&u, 1));
  return o.error_mm + price * o.outside_mm;
}

// The least cost of any layer of 16 cells, by trying all of them.
double best_of_all_mm(const StripInstance& in, double price) {
  double best = 1e9;
  DropletPattern u(in.setup.grid);
  for (std::uint32_t bits = 0; bits < 1u << 16; ++bits) {
    bool allowed = true;
    for (std::size_t c = 0; c < 16; ++c) {
      u.cells[c] = bits >> c & 1;
      allowed = allowed && (!u.cells[c] || in.setup.mask.cells[c]);
    }
    if (allowed) best = std::min(best, cost_mm(in, u, price));
  }
  return best;
}

CellCost priced(double price) {
  CellCost cost;
  cost.outside = float(price);
  return cost;
}

}  // namespace

TEST_CASE(
    "With a price of ink beside the part no layer of 4 x 4 cells beats the bound, and the solver finds the "
    "best one") {
  int proved = 0, differs = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, seed % 3 == 0);
    const double price = 0.5 * double(seed);
    const double best = best_of_all_mm(in, price);
    for (int rows = 1; rows <= 4; ++rows) {
      BoundOptions options{rows, 40, 0.0};
      options.cost = priced(price);
      const LowerBound b = lower_bound(in.setup, in.height, in.materials, best, options, serially);
      INFO("seed " << seed << ", rows " << rows);
      CHECK(b.total_mm <= best + kOutsideRounding_mm);
      if (rows == 4) CHECK(b.total_mm > best - kOutsideRounding_mm);  // one strip: nothing is relaxed
      proved += b.total_mm > best - 1e-6;
    }
    LayerProblem problem(in.setup, in.height, in.materials);
    LayerSolverOptions solver;
    solver.cost = priced(price);
    const double found_mm = solve_layer(problem, solver, serially).found_mm;
    const double judged_mm = cost_mm(in, problem.drops(in.setup.grid), price);
    CHECK(judged_mm < best + 1e-6);
    CHECK(std::abs(found_mm - judged_mm) < 1e-6);
    differs += best > best_of_all_mm(in, 0.0) + kOutsideRounding_mm;
  }
  CHECK(proved >= 44);   // of 48
  CHECK(differs >= 10);  // the price matters
}

TEST_CASE("Random multipliers prove a bound of the price of ink beside the part too") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const StripInstance in = random_instance(seed, 4, 4, false);
    const double best = best_of_all_mm(in, 2.0);
    RandomStream random(seed, Purpose::kInstance);
    std::vector<float> multipliers(3 * 4 * kSharedPatterns);
    for (float& v : multipliers) v = float(random.uniform(-1e-3, 1e-3));
    CHECK(certified_bound_mm(in.setup, in.height, in.materials, 1, multipliers, priced(2.0)) <=
          best + kOutsideRounding_mm);
  }
}

TEST_CASE("Bound, strips, patches and layers of a larger part agree about the price of ink beside it") {
  for (std::uint64_t seed = 21; seed <= 24; ++seed) {
    const StripInstance in = random_instance(seed, 20, 17, seed % 2 == 0);
    LayerProblem problem(in.setup, in.height, in.materials);
    LayerSolverOptions solver{3, 2, 30, 0.0};
    solver.cost = priced(1.5);
    const double found_mm = solve_layer(problem, solver, serially).found_mm;
    const double known_mm = cost_mm(in, problem.drops(in.setup.grid), 1.5);
    CHECK(std::abs(found_mm - known_mm) < 1e-6);
    BoundOptions options{2, 12, 0.0};
    options.cost = solver.cost;
    const LowerBound b = lower_bound(in.setup, in.height, in.materials, known_mm, options, serially);
    CHECK(b.total_mm <= known_mm + kOutsideRounding_mm);
    CHECK(b.total_mm > 0.995 * known_mm);
    if (in.materials.size() == 0)
      CHECK(std::abs(outside_rise_mm(in.setup, in.height, problem.drops(in.setup.grid)) -
                     (known_mm - by_model_mm(in, problem.drops(in.setup.grid))) / 1.5) < 1e-9);
  }
}

TEST_CASE(
    "The objective of a plan holds the price of ink beside the part, and so do its gains, in both "
    "precisions") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (const ErrorKind kind : {ErrorKind::kAbsolute, ErrorKind::kSquare}) {
      const StripInstance in = random_instance(seed, 9, 8, false);
      const int layers = 1 + int(seed % 3);
      const double price = 1.7, layer_mm = in.setup.model.layer_height_mm();
      HorizonObjective objective(in.setup, layers, 1, kind, 0.0, 0.0, price);
      objective.set_surface(in.height, 1.0);
      RandomStream random(seed, Purpose::kInstance);
      std::vector<DropletPattern> plan;
      for (int n = 0; n < layers; ++n) plan.push_back(random_drops(in, random));
      const auto judged = [&] {
        const Outcome o = by_model(in, plan);
        const double cells = double(in.setup.mask.count());
        return kind == ErrorKind::kAbsolute
                   ? (o.error_mm + price * o.outside_mm) / cells
                   : std::sqrt((o.squares_mm2 + price * layer_mm * o.outside_mm) / cells);
      };
      objective.set_plan(plan);
      INFO("seed " << seed << ", layers " << layers << ", squares " << (kind == ErrorKind::kSquare));
      CHECK(std::abs(objective.value_mm() - judged()) < kOutsideRounding_mm);
      HorizonState field(in.setup, in.height, {}, layers, objective.cost());
      field.set_drops(plan);
      DeltaCache flips(
          field, kind == ErrorKind::kSquare ? DeltaCache::Wanted::kSquares : DeltaCache::Wanted::kAbsolute);
      for (int move = 0; move < 60; ++move) {
        const auto cells = objective.part_cells();
        const std::uint32_t cell = cells[random.below(std::uint32_t(cells.size()))];
        const int layer = int(random.below(std::uint32_t(layers)));
        std::uint8_t& drop = plan[std::size_t(layer)].cells[cell];
        const Move m{layer, cell, drop ? -1 : 1};
        const double before_mm = judged(), gain_mm = objective.gain_mm(m);
        const ObjectiveDeltas s = flips.sums(layer, field.at(cell));
        drop = !drop;
        const double after_mm = judged(), n = double(cells.size());
        CHECK(std::abs(gain_mm - (after_mm - before_mm)) < 1e-10);
        if (kind == ErrorKind::kAbsolute)
          CHECK(std::abs(s.abs_error_mm / n - (after_mm - before_mm)) < 1e-6);
        else
          CHECK(std::abs(s.second_mm2 / n - (after_mm * after_mm - before_mm * before_mm)) < 1e-8);
        objective.apply(m);
        flips.flip(layer, field.at(cell));
      }
      CHECK(std::abs(objective.value_mm() - judged()) < 1e-9);
      const double by_flips = field.second_mm2;
      flips.refresh();
      if (kind == ErrorKind::kSquare) CHECK(by_flips == Approx(field.second_mm2).epsilon(1e-3));
    }
}

TEST_CASE(
    "Every search of MPC reports the objective with the price, and certified plans a layer no worse than the "
    "others") {
  for (std::uint64_t seed = 31; seed <= 34; ++seed) {
    const StripInstance in = random_instance(seed, 14, 13, false);
    double least_mm = 1e9, certified_mm = 0.0;
    for (const MpcMethod method :
         {MpcMethod::kGreedy, MpcMethod::kDescent, MpcMethod::kStripDp, MpcMethod::kCertified}) {
      ControlOptions o;
      o.mpc.method = method;
      o.mpc.outside_price = 1.0;
      o.mpc.sweeps = 40;
      const Decision d = Mpc(in.setup, o).decide({in.height, 0, 0, 0.0});
      REQUIRE(d.kind == Decision::Kind::kPrint);
      CHECK(d.objective_mm ==
            Approx(cost_mm(in, d.drops, 1.0) / double(in.setup.mask.count())).epsilon(1e-9));
      least_mm = std::min(least_mm, d.objective_mm);
      certified_mm = d.objective_mm;
    }
    CHECK(certified_mm < least_mm + 1e-8);
  }
}

TEST_CASE("The dearer ink beside the part, the less of it MPC prints") {
  const StripInstance in = random_instance(41, 16, 16, false);
  double before_mm = 1e9;
  for (const double price : {0.0, 2.0, 5.0, 10.0})
    for (const int horizon : {1, 2}) {
      ControlOptions o;
      o.mpc.method = MpcMethod::kStripDp;
      o.mpc.horizon = horizon;
      o.mpc.outside_price = price;
      const Decision d = Mpc(in.setup, o).decide({in.height, 0, 0, 0.0});
      if (horizon > 1) continue;
      const double outside_mm = by_model(in, std::span(&d.drops, 1)).outside_mm;
      CHECK(outside_mm <= before_mm);
      before_mm = outside_mm;
    }
  ControlOptions o;
  o.mpc.outside_price = 1.0;
  o.mpc.alpha = {{1, 0.5}};
  CHECK_THROWS_WITH(Mpc(in.setup, o), Catch::Contains("alpha = 1"));
  o = {};
  o.mpc.edge_lag_layers = 0.8;
  CHECK_THROWS_WITH(Mpc(in.setup, o), Catch::Contains("rise_layers"));
}

TEST_CASE(
    "An edge lags by its sides that lie outside, and its reference rises with the part until all but the lag "
    "is printed") {
  const GridSpec g{5, 4};
  Setup s{g, HeightMap(g, 0.1), Mask(g, 1), {}};
  for (int i = 0; i < 5; ++i) s.mask.at(i, 3) = 0;  // a part of 5 x 3 cells up to the border of the grid
  const EdgeReference edge(s, 0.5, 0.8);
  const double layer_mm = s.model.layer_height_mm();
  CHECK(edge.lag_mm().at(2, 1) == 0.0);
  CHECK(edge.lag_mm().at(2, 2) == Approx(0.5 * layer_mm));
  CHECK(edge.lag_mm().at(0, 0) == Approx(layer_mm));
  CHECK(edge.lag_mm().at(4, 2) == Approx(layer_mm));
  HeightMap height(g);
  for (std::size_t c = 0; c < g.size(); ++c) height.cells[c] = 0.05 - edge.lag_mm().cells[c];
  const HeightMap next = edge.next(s.target, height).value();
  CHECK(next.at(2, 1) == Approx(0.05 + 0.8 * layer_mm));
  CHECK(next.at(0, 0) == Approx(0.05 + 0.8 * layer_mm - layer_mm));
  for (std::size_t c = 0; c < g.size(); ++c) height.cells[c] = 0.1 - edge.lag_mm().cells[c] - 0.4 * layer_mm;
  CHECK(!edge.next(s.target, height));
  height.at(2, 1) -= layer_mm;  // one cell still lacks more than half a layer
  CHECK(edge.next(s.target, height).value().at(2, 1) == Approx(0.1 - 0.6 * layer_mm));
}

TEST_CASE("The third row from the outline lags too, so that the second is a ridge") {
  const GridSpec g{9, 9};
  Setup s{g, HeightMap(g, 0.1), Mask(g, 0), {}};
  for (int j = 1; j < 8; ++j)
    for (int i = 1; i < 8; ++i) s.mask.at(i, j) = 1;  // 7 x 7 cells
  const EdgeReference edge(s, 0.5, 0.8);
  const double lag_mm = 0.5 * s.model.layer_height_mm();
  const double along[] = {2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0}, across[] = {1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0};
  for (int i = 0; i < 7; ++i) {
    CHECK(edge.lag_mm().at(1 + i, 1) == Approx(along[i] * lag_mm));
    CHECK(edge.lag_mm().at(4, 1 + i) == Approx(across[i] * lag_mm));
  }
  CHECK(edge.lag_mm().at(2, 2) == 0.0);
}
