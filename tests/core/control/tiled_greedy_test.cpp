// The greedy search by tiles: a local optimum of the whole grid, the same bytes in any order of the tiles.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/mpc.h"
#include "core/control/mpc/objective.h"
#include "core/control/mpc/tiled_greedy.h"
#include "core/control/prediction.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::test;

namespace {

mpc::TiledLayer tiled(const StripInstance& in, const MpcOptions& options = {},
                      const ParallelFor& parallel = serially) {
  return mpc::tiled_greedy(in.setup, in.height, options, 1, 0, parallel);
}

double model_error_mm(const StripInstance& in, const DropletPattern& drops) {
  return objective_mm(Predictor(in.setup).after(in.height, drops), in.setup.target, in.setup.mask, 1.0);
}

// Changes of one droplet that would better the plan, tried one by one on the whole grid.
int bettering_changes(const StripInstance& in, const DropletPattern& drops, double outside_price = 0.0) {
  mpc::HorizonObjective whole(in.setup, 1, 1, ErrorKind::kAbsolute, 0.0, 0.0, outside_price);
  whole.set_surface(in.height, 1.0);
  whole.set_plan(std::vector<DropletPattern>{drops});
  int n = 0;
  for (const std::uint32_t cell : whole.part_cells())
    n += whole.gain_mm({0, cell, drops.cells[cell] ? -1 : 1}) < -mpc::kMinGain_mm;
  return n;
}

}  // namespace

TEST_CASE("No single droplet betters a layer that was searched by tiles, in them or across their borders") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const StripInstance in =
        random_instance(seed, 300, 140, false);  // 3 x 2 tiles, of 44 and 12 cells the last
    const mpc::TiledLayer layer = tiled(in);
    CAPTURE(seed, layer.evaluations);
    CHECK(layer.optimal);
    CHECK(bettering_changes(in, layer.drops) == 0);
    for (std::size_t c = 0; c < in.height.size(); ++c)
      if (layer.drops.cells[c]) REQUIRE(in.setup.mask.cells[c]);
  }
}

TEST_CASE("Nor does one where ink beside the part has a price") {
  const StripInstance in = random_instance(4, 200, 200, false);
  MpcOptions options;
  options.outside_price = 2.0;
  const mpc::TiledLayer layer = tiled(in, options);
  CHECK(layer.optimal);
  CHECK(bettering_changes(in, layer.drops, 2.0) == 0);
}

TEST_CASE("The objective of a layer by tiles is that of the model on the whole grid") {
  const StripInstance in = random_instance(5, 260, 90, false);
  const mpc::TiledLayer layer = tiled(in);
  CHECK(layer.objective_mm == model_error_mm(in, layer.drops));
}

TEST_CASE("Tiles that are searched in any order give the same droplets") {
  const StripInstance in = random_instance(6, 300, 300, false);
  const mpc::TiledLayer layer = tiled(in);
  const ParallelFor backwards = [](int n, const std::function<void(int)>& body) {
    while (n-- > 0) body(n);
  };
  const mpc::TiledLayer other = tiled(in, {}, backwards);
  CHECK(other.drops == layer.drops);
  CHECK(other.evaluations == layer.evaluations);
}

TEST_CASE("A layer by tiles is as good as one that is searched as a whole, to 1 %") {
  const StripInstance in = random_instance(7, 300, 150, false);
  mpc::HorizonObjective whole(in.setup, 1, 1);
  whole.set_surface(in.height, 1.0);
  whole.set_plan(std::vector<DropletPattern>{DropletPattern(in.setup.grid)});
  RandomStream random(1, Purpose::kGreedySearch);
  mpc::greedy_search(whole, {16, 20'000'000}, random);
  CHECK(tiled(in).objective_mm < 1.01 * whole.value_mm());
}

TEST_CASE("The search by tiles never evaluates more than it may, and says when it was not enough") {
  const StripInstance in = random_instance(8, 300, 150, false);
  const std::int64_t enough = tiled(in).evaluations;
  for (const std::int64_t limit : {std::int64_t(1), std::int64_t(1000), enough / 2}) {
    MpcOptions options;
    options.max_evaluations = limit;
    const mpc::TiledLayer layer = tiled(in, options);
    CAPTURE(limit, layer.evaluations, enough);
    CHECK(layer.evaluations <= limit + 6);  // a tile without a share counts as one
    CHECK_FALSE(layer.optimal);
    CHECK(layer.objective_mm == model_error_mm(in, layer.drops));
  }
}

TEST_CASE("Tiles need hardly more evaluations a cell as the grid grows") {
  const auto per_cell = [](int nx) {
    const StripInstance in = random_instance(9, nx, nx, false);
    return double(tiled(in).evaluations) / double(in.height.size());
  };
  const double small = per_cell(128), large = per_cell(512);
  CAPTURE(small, large);
  CHECK(large < 1.6 * small);  // rims are searched again
}

TEST_CASE(
    "MPC decides a part of more than a quarter of a million cells by tiles, and a smaller one as before") {
  const StripInstance in = random_instance(10, 560, 560, false);
  REQUIRE(std::size_t(std::ranges::count(in.setup.mask.cells, 1)) > mpc::kTiledCells);
  ControlOptions o;
  const Decision d = Mpc(in.setup, o).decide({in.height, 0});
  REQUIRE(d.kind == Decision::Kind::kPrint);
  CHECK(d.reason == "no single droplet more or less betters this layer");
  CHECK(d.drops == tiled(in, o.mpc).drops);
  CHECK(d.objective_mm == model_error_mm(in, d.drops));
  CHECK(d.objective_none_mm == objective_mm(in.height, in.setup.target, in.setup.mask, 1.0));
}

TEST_CASE("A part of many tiles that is as high as it should be gets no layer") {
  StripInstance in = random_instance(11, 560, 560, false);
  in.height.cells = in.setup.target.cells;
  const Decision d = Mpc(in.setup, ControlOptions{}).decide({in.height, 0});
  CHECK(d.kind == Decision::Kind::kEnd);
  CHECK(d.drops.total() == 0);
}
