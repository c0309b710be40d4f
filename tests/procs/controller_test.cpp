#include "procs/controller/node.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "firn/fault_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/convert.h"
#include "lcmtypes/outcome.h"
#include "tests/support/node_bench.h"

namespace firn {
namespace {

Experiment small(const std::string& scheme) {
  Experiment e;
  e.grid = {9, 7, 0.25, 0.25, 1.0, -2.0};
  e.control.scheme = scheme;
  if (scheme == "registration") e.grid.nx = e.grid.ny = 80;  // room for its marks
  return e;
}

Mask disc(const GridSpec& g) {
  Mask m(g);
  for (int j = 1; j + 1 < g.ny; ++j)
    for (int i = 1; i + 1 < g.nx; ++i) m.at(i, j) = 1;
  return m;
}

Experiment with_estimator(Experiment e) {
  e.estimator.droplets = e.control.adapt_model = "on";
  return e;
}

struct Bench : test::NodeBench {
  explicit Bench(const std::string& scheme, bool adapt = false)
      : NodeBench(NodeId::kController,
                  std::make_unique<ControllerNode>(adapt ? with_estimator(small(scheme)) : small(scheme), HeightMap(small(scheme).grid, 0.05),
                                                   disc(small(scheme).grid))) {
    start();
  }
  layer_plan_t ask(const HeightMap& h, int layer, std::int64_t map_id, int attempt = 0) {
    height_map_t m{};
    m.layer = layer;
    m.attempt = attempt;
    m.map_id = map_id;
    m.noise_std_mm = 0.0005;
    set_height(m, h);
    m.quality.assign(h.size(), 0);
    give(channels::kHeightMap, m);
    return last(channels::kLayerPlan);
  }
  std::size_t faults() const { return all(channels::fault(NodeId::kController)).size(); }
};

HeightMap at_layer(const GridSpec& g, int layer) { return HeightMap(g, layer * 0.0076); }

}  // namespace

TEST_CASE(
    "A plan answers its map: layer + 1, the same map_id and attempt, droplets on the part only, for every "
    "scheme") {
  for (const control::Scheme& s : control::schemes()) {
    Bench bench{std::string(s.name)};
    const GridSpec g = small(std::string(s.name)).grid;
    const Mask mask = disc(g);
    for (int layer = 0; layer < 3; ++layer) {
      const layer_plan_t p = bench.ask(at_layer(g, layer), layer, 100 + layer, layer % 2);
      CHECK(p.layer == layer + 1);
      CHECK(p.map_id == 100 + layer);
      CHECK(p.attempt == layer % 2);
      CHECK(PlanDecision(p.decision) == PlanDecision::kPrint);
      CHECK(from_message(p.grid) == g);
      CHECK(p.passes == drops_of(p).passes());
      CHECK(drops_of(p).total() > 0);
      for (std::size_t c = 0; c < g.size(); ++c)
        if (!mask.cells[c]) CHECK(p.drops[c] == 0);
      CHECK_FALSE(p.reason.empty());
    }
    CHECK(bench.all(channels::kLayerPlan).size() == 3);
    CHECK(bench.faults() == 0);
    const layer_plan_t end = bench.ask(HeightMap(g, 0.0532), 7, 200);
    CHECK(PlanDecision(end.decision) == PlanDecision::kEnd);
    CHECK(drops_of(end).total() == 0);
  }
}

TEST_CASE("A map that cannot be used stops the print with a fault that names why, and changes no state") {
  for (const char* scheme : {"smf", "mpc"}) {
    Bench bench(scheme), clean(scheme);
    const GridSpec g = small("").grid;
    bench.ask(at_layer(g, 0), 0, 1);
    clean.ask(at_layer(g, 0), 0, 1);

    HeightMap hole = at_layer(g, 1);
    hole.at(4, 3) = kNotMeasured;
    CHECK(PlanDecision(bench.ask(hole, 1, 2).decision) == PlanDecision::kStop);
    CHECK_THAT(bench.last(channels::fault(NodeId::kController)).text, Catch::Contains("cell (4, 3)"));
    CHECK(Severity(bench.last(channels::fault(NodeId::kController)).severity) == Severity::kStop);

    GridSpec other = g;
    other.pitch_x_mm = 0.3;
    CHECK(PlanDecision(bench.ask(HeightMap(other), 1, 3).decision) == PlanDecision::kStop);
    CHECK(PlanDecision(bench.ask(HeightMap(GridSpec{2, 2}), 1, 4).decision) == PlanDecision::kStop);
    CHECK(bench.faults() == 3);

    HeightMap uneven = at_layer(g, 1);
    uneven.at(3, 3) += 0.006;
    const layer_plan_t a = bench.ask(uneven, 1, 6), b = clean.ask(uneven, 1, 6);
    CHECK(a.drops == b.drops);
    CHECK(a.objective_mm == b.objective_mm);
  }
}

TEST_CASE(
    "The node is built from the resolved configuration and the run's blobs, and names what is missing") {
  Experiment e = small("mpc");
  e.part.shape.diameter_mm = 1.2;
  const auto target = to_npy(HeightMap(e.grid, 0.05)), mask = to_npy(disc(e.grid));
  const Blobs blobs = {{"target", "", target}, {"mask", "", mask}};
  CHECK(make_controller_node(dump(e), blobs) != nullptr);
  CHECK_THROWS_WITH(make_controller_node(dump(e), {{"target", "", target}}), Catch::Contains("mask"));
  CHECK_THROWS_WITH(make_controller_node(dump(e), {{"target", "", mask}, {"mask", "", mask}}),
                    Catch::Contains("target"));
}

TEST_CASE("With control.adapt_model MPC plans with the newest HEIGHT_MODEL; without it the node does not even listen") {
  Experiment e = small("mpc");
  const HeightMap target(e.grid, 0.05);
  const auto listens = [](const Node& node) {
    return std::ranges::any_of(node.routes(), [](const Node::Route& r) { return r.channel == channels::kHeightModel.name; });
  };
  CHECK_FALSE(listens(ControllerNode(e, target, disc(e.grid))));
  CHECK(listens(ControllerNode(with_estimator(e), target, disc(e.grid))));

  // Droplets turn out to be twice as large: where the old model wants all cells, half of them will do.
  Bench plain("mpc"), adapted("mpc", true);
  height_model_t m{};
  m.layers_used = 1;
  m.h1_mm = 0.0088, m.h2_mm = 0.0012, m.h3_mm = 0.0004, m.layer_height_mm = 0.0152;
  adapted.give(channels::kHeightModel, m);
  const HeightMap h(e.grid, 0.05 - 0.0070);
  const layer_plan_t a = plain.ask(h, 6, 1), b = adapted.ask(h, 6, 1);
  CHECK(drops_of(b).total() < 0.7 * double(drops_of(a).total()));
  CHECK(drops_of(b).total() > 0);
  m.layers_used = 0;  // nothing learned yet: what was believed stands
  Bench early("mpc", true);
  early.give(channels::kHeightModel, m);
  CHECK(early.ask(h, 6, 1).drops == a.drops);
}

TEST_CASE("The same maps give the same plan bytes") {
  for (const control::Scheme& s : control::schemes()) {
    const GridSpec g = small(std::string(s.name)).grid;
    Bench a{std::string(s.name)}, b{std::string(s.name)};
    RandomStream random(4, Purpose::kTest);
    for (int layer = 0; layer < 6; ++layer) {
      HeightMap h = at_layer(g, layer);
      for (double& v : h.cells) v += random.uniform(-0.004, 0.004);
      a.ask(h, layer, layer + 1);
      b.ask(h, layer, layer + 1);
    }
    REQUIRE(a.sent.size() == b.sent.size());
    for (std::size_t n = 0; n < a.sent.size(); ++n) CHECK(a.sent[n].bytes == b.sent[n].bytes);
  }
}

}  // namespace firn
