#include "procs/controller/node.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/deposition/height_change.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "firn/deposition_report_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/convert.h"
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
      : NodeBench(NodeId::kController, std::make_unique<ControllerNode>(
                                           adapt ? with_estimator(small(scheme)) : small(scheme),
                                           HeightMap(small(scheme).grid, 0.05), disc(small(scheme).grid))) {
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
    if (s.name == "auto") continue;  // it waits for the reports of what was fired: below
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

TEST_CASE(
    "A guessed height has no weight in a decision: any guess gives the same plan, a measured one another") {
  for (const char* scheme : {"smf", "mpc", "threshold"}) {
    INFO(scheme);
    const GridSpec g = small("").grid;
    // Row 3 of the second map is not measured; its guess is far too high, far too low, or the model's height.
    const auto plan_of = [&](double guess_mm, bool guessed, std::int32_t rows) {
      Bench bench(scheme);
      height_map_t m{};
      m.map_id = 1;
      m.noise_std_mm = 1e-6;
      m.rows_expected = m.rows_received = rows;
      set_height(m, HeightMap(g, 0.0));
      m.quality.assign(g.size(), 0);
      bench.give(channels::kHeightMap, m);
      HeightMap h(g, 0.0076);
      for (int i = 0; i < g.nx; ++i) {
        h.at(i, 3) = guess_mm;
        m.quality[g.index(i, 3)] = std::int8_t(guessed);
      }
      m.layer = 1;
      m.map_id = 2;
      m.rows_received = rows - (rows > 0);
      set_height(m, h);
      bench.give(channels::kHeightMap, m);
      return bench.last(channels::kLayerPlan).drops;
    };
    const auto plan = plan_of(0.06, true, g.ny);
    CHECK(plan == plan_of(-0.06, true, g.ny));
    CHECK(plan == plan_of(0.0, true, g.ny));
    CHECK(plan != plan_of(0.06, false, g.ny));
    CHECK(plan_of(0.06, true, 0) == plan_of(0.06, false, 0));  // a map of a version that did not count
    int fired = 0;  // where nothing was measured, the print goes on as the model expects
    for (int i = 1; i + 1 < g.nx; ++i) fired += plan[std::size_t(g.index(i, 3))];
    CHECK(fired > 0);
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

TEST_CASE(
    "With control.adapt_model MPC plans with the newest HEIGHT_MODEL, and without it the node does not even "
    "listen") {
  Experiment e = small("mpc");
  const HeightMap target(e.grid, 0.05);
  const auto listens = [](const Node& node) {
    return std::ranges::any_of(node.routes(),
                               [](const Node::Route& r) { return r.channel == channels::kHeightModel.name; });
  };
  CHECK_FALSE(listens(ControllerNode(e, target, disc(e.grid))));
  CHECK(listens(ControllerNode(with_estimator(e), target, disc(e.grid))));

  // Droplets turn out to be twice as large: half of the cells that the old model wants are enough.
  Bench plain("mpc"), adapted("mpc", true);
  height_model_t m{};
  m.layers_used = 1;
  m.h1_mm = 0.0088;
  m.h2_mm = 0.0012;
  m.h3_mm = 0.0004;
  m.layer_height_mm = 0.0152;
  adapted.give(channels::kHeightModel, m);
  const HeightMap h(e.grid, 0.05 - 0.0070);
  const layer_plan_t a = plain.ask(h, 6, 1), b = adapted.ask(h, 6, 1);
  CHECK(drops_of(b).total() < 0.7 * double(drops_of(a).total()));
  CHECK(drops_of(b).total() > 0);
  m.layers_used = 0;  // nothing learned yet: the configured model holds
  Bench early("mpc", true);
  early.give(channels::kHeightModel, m);
  CHECK(early.ask(h, 6, 1).drops == a.drops);
}

namespace {

Experiment with_filter(Experiment e) {
  e.control.height_estimate = "kalman";
  return e;
}

// The node that blends maps and droplets, on a part that is far from done.
struct FilterBench : test::NodeBench {
  explicit FilterBench(const Experiment& e = with_filter(small("mpc")))
      : NodeBench(NodeId::kController,
                  std::make_unique<ControllerNode>(e, HeightMap(e.grid, 0.05), disc(e.grid))) {
    start();
  }
  void map(const HeightMap& h, int layer, int attempt = 0) {
    height_map_t m{};
    m.layer = layer;
    m.attempt = attempt;
    m.map_id = ++maps;
    m.noise_std_mm = 0.001;
    set_height(m, h);
    m.quality.assign(h.size(), 0);
    give(channels::kHeightMap, m);
  }
  deposition_report_t report_of(const layer_plan_t& plan) const {
    deposition_report_t r{};
    r.layer = plan.layer;
    r.passes = 1;
    r.material = std::int8_t(Material::kA);
    r.sub_patterns = 1;
    r.cured = 1;
    r.outcome = std::int8_t(Outcome::kDone);
    r.grid = plan.grid;
    r.n = plan.n;
    r.drops = plan.drops;
    r.commanded = r.triggered_stage = r.triggered_jet = r.unknown_from = r.unknown_to =
        drops_of(plan).total();
    r.confirmed = -1;
    return r;
  }
  std::size_t plans() const { return all(channels::kLayerPlan).size(); }
  std::size_t faults() const { return all(channels::fault(NodeId::kController)).size(); }
  std::int64_t maps = 0;
};

}  // namespace

TEST_CASE("With height_estimate = kalman noise of one map moves the plan less than it moves the map") {
  const GridSpec g = small("mpc").grid;
  const deposition::DropletModel model;
  HeightMap truth(g, 0.0);
  FilterBench b;
  Bench plain("mpc");
  RandomStream random(8, Purpose::kTest);
  double off_filter = 0.0, off_map = 0.0;
  b.map(truth, 0);
  for (int layer = 1; layer <= 5; ++layer) {
    const layer_plan_t plan = b.last(channels::kLayerPlan);
    deposition::HeightChange<1>(g, deposition::stencil_of(model), deposition::Border::kLose)
        .deposit(truth, drops_of(plan));
    HeightMap noisy = truth;
    for (double& v : noisy.cells) v += random.uniform(-0.0017, 0.0017);  // 1 um
    b.give(channels::kDepositionReport, b.report_of(plan));
    b.map(noisy, layer);
    const double none_filter = b.last(channels::kLayerPlan).objective_none_mm,
                 none_map = plain.ask(noisy, layer, layer).objective_none_mm;
    const double none = plain.ask(truth, layer, layer).objective_none_mm;
    off_filter += std::abs(none_filter - none);
    off_map += std::abs(none_map - none);
  }
  CHECK(b.plans() == 6);
  CHECK(b.faults() == 0);
  CHECK(off_filter < 0.7 * off_map);
}

TEST_CASE("Scheme auto decides on the blended height, and tells of it in its plan") {
  const GridSpec g = small("auto").grid;
  FilterBench b(small("auto"));
  b.map(HeightMap(g, 0.0), 0);
  b.give(channels::kDepositionReport, b.report_of(b.last(channels::kLayerPlan)));
  b.map(at_layer(g, 1), 1);
  CHECK(b.plans() == 2);
  CHECK_THAT(b.last(channels::kLayerPlan).reason, Catch::Contains("auto: MPC of strips that rise together"));
}

TEST_CASE("Scheme auto with smoothed maps decides on the map") {
  Experiment e = small("auto");
  e.control.smoothing = 1.0;
  FilterBench b(e);
  b.map(HeightMap(e.grid, 0.0), 0);
  CHECK_THAT(b.last(channels::kLayerPlan).reason, Catch::Contains("auto: MPC of strips on the map"));
}

TEST_CASE("Scheme auto reports a change of its choice as a notice") {
  const GridSpec g = small("auto").grid;
  FilterBench b(small("auto"));
  RandomStream random(3, Purpose::kTest);
  HeightMap h(g, 0.0);
  b.map(h, 0);
  for (int layer = 1; layer < 6; ++layer) {
    b.give(channels::kDepositionReport, b.report_of(b.last(channels::kLayerPlan)));
    for (double& v : h.cells) v += random.uniform(0.0, 0.01);  // whatever was fired
    b.map(h, layer);
  }
  REQUIRE(b.faults() > 0);
  CHECK(Severity(b.last(channels::fault(NodeId::kController)).severity) == Severity::kNotice);
  CHECK_THAT(b.last(channels::fault(NodeId::kController)).text, Catch::Contains("threshold"));
}

TEST_CASE(
    "With droplet_factors a jet that gives a sixth less is planned with, and without, the plan still "
    "believes the model") {
  const deposition::DropletModel model;
  const auto believed = [&](const std::string& factors) {
    Experiment e = with_filter(small("mpc"));
    e.control.droplet_factors = factors;
    FilterBench b(e);
    const GridSpec& g = e.grid;
    HeightMap truth(g, 0.0);
    b.map(truth, 0);
    for (int layer = 1; layer <= 4; ++layer) {
      const layer_plan_t plan = b.last(channels::kLayerPlan);
      deposition::HeightChange<1>(g, deposition::stencil_of(model.times(5.0 / 6.0)),
                                  deposition::Border::kLose)
          .deposit(truth, drops_of(plan));
      b.give(channels::kDepositionReport, b.report_of(plan));
      b.map(truth, layer);
    }
    CHECK(b.faults() == 0);
    const layer_plan_t plan = b.last(channels::kLayerPlan);  // of all cells: the part is far from done
    return plan.objective_none_mm - plan.objective_mm;
  };
  CHECK(believed("on") / believed("off") == Approx(5.0 / 6.0).epsilon(0.03));
  CHECK(believed("together") / believed("off") == Approx(5.0 / 6.0).epsilon(0.03));
}

TEST_CASE(
    "A map that overtakes the reports of its layer waits for them, and without any it counts alone, and a "
    "warning says so") {
  const GridSpec g = small("mpc").grid;
  FilterBench in_order, late, never;
  for (FilterBench* b : {&in_order, &late, &never}) b->map(HeightMap(g, 0.0), 0);
  const deposition_report_t report = in_order.report_of(in_order.last(channels::kLayerPlan));
  HeightMap first = at_layer(g, 1);
  first.at(4, 3) += 0.002;
  in_order.give(channels::kDepositionReport, report);
  in_order.map(first, 1);
  late.map(first, 1);
  CHECK(late.plans() == 1);
  late.give(channels::kDepositionReport, report);
  CHECK(late.plans() == 2);
  CHECK(late.last(channels::kLayerPlan).drops == in_order.last(channels::kLayerPlan).drops);
  CHECK(late.last(channels::kLayerPlan).objective_mm == in_order.last(channels::kLayerPlan).objective_mm);
  CHECK(late.last(channels::kLayerPlan).map_id == 2);

  never.map(first, 1);
  CHECK(never.plans() == 1);
  REQUIRE(never.wake());
  CHECK(never.plans() == 2);
  CHECK(never.faults() == 1);
  CHECK(Severity(never.last(channels::fault(NodeId::kController)).severity) == Severity::kWarning);
  Bench plain("mpc");
  CHECK(never.last(channels::kLayerPlan).objective_none_mm ==
        Approx(plain.ask(first, 1, 2).objective_none_mm).epsilon(1e-6));
  never.give(channels::kDepositionReport, report);  // too late: nothing is counted twice
  CHECK(never.plans() == 2);
}

TEST_CASE("A second map of a layer replaces the first, and one of a layer long past is refused") {
  const GridSpec g = small("mpc").grid;
  FilterBench twice, once;
  for (FilterBench* b : {&twice, &once}) {
    b->map(HeightMap(g, 0.0), 0);
    b->give(channels::kDepositionReport, b->report_of(b->last(channels::kLayerPlan)));
  }
  HeightMap wrong = at_layer(g, 1);
  for (double& v : wrong.cells) v += 0.002;
  twice.map(wrong, 1, 0);
  twice.map(at_layer(g, 1), 1, 1);
  once.map(at_layer(g, 1), 1);
  CHECK(twice.last(channels::kLayerPlan).objective_none_mm ==
        once.last(channels::kLayerPlan).objective_none_mm);
  twice.map(HeightMap(g, 0.0), 0, 2);
  CHECK(PlanDecision(twice.last(channels::kLayerPlan).decision) == PlanDecision::kStop);
  CHECK_THAT(twice.last(channels::fault(NodeId::kController)).text, Catch::Contains("came after layer 1"));
}

TEST_CASE(
    "control.mpc.error = square and square_mean reach the scheme: objectives are roots of mean squares, and "
    "the mean's square counts eight times") {
  const auto error = GENERATE(control::ErrorKind::kSquare, control::ErrorKind::kSquareMean);
  Experiment e = small("mpc");
  e.control.mpc.method = control::MpcMethod::kStripDp;
  e.control.mpc.error = error;
  const Mask mask = disc(e.grid);
  test::NodeBench b(NodeId::kController, std::make_unique<ControllerNode>(e, HeightMap(e.grid, 0.05), mask));
  b.start();
  height_map_t m{};
  m.map_id = 1;
  HeightMap h(e.grid, 0.05);
  RandomStream random(2, Purpose::kTest);
  double squares = 0.0, sum = 0.0, cells = 0.0;
  for (std::size_t c = 0; c < h.size(); ++c) {
    h.cells[c] -= random.uniform(0.0, 0.0076);
    if (mask.cells[c]) {
      squares += (0.05 - h.cells[c]) * (0.05 - h.cells[c]);
      sum += 0.05 - h.cells[c];
      cells += 1.0;
    }
  }
  set_height(m, h);
  m.quality.assign(h.size(), 0);
  b.give(channels::kHeightMap, m);
  const layer_plan_t plan = b.last(channels::kLayerPlan);
  const double weight = error == control::ErrorKind::kSquareMean ? 8.0 : 0.0, mean = sum / cells;
  CHECK(plan.objective_none_mm == Approx(std::sqrt(squares / cells + weight * mean * mean)));
  CHECK(plan.objective_mm < plan.objective_none_mm);
}

TEST_CASE("A plan is the same bytes on whatever threads the process hands its node") {
  Experiment e = small("mpc");
  e.control.mpc.method = control::MpcMethod::kStripDp;
  e.grid.nx = 40;
  e.grid.ny = 60;
  const Blobs blobs = {{"target", "", to_npy(HeightMap(e.grid, 0.05))},
                       {"mask", "", to_npy(Mask(e.grid, 1))}};
  int calls = 0;
  const ParallelFor backwards = [&](int n, const std::function<void(int)>& body) {
    ++calls;
    for (int i = n - 1; i >= 0; --i) body(i);
  };
  HeightMap h(e.grid, 0.05);
  RandomStream random(3, Purpose::kTest);
  for (double& v : h.cells) v -= random.uniform(0.0, 0.0076);
  height_map_t m{};
  m.map_id = 1;
  set_height(m, h);
  m.quality.assign(h.size(), 0);
  std::vector<layer_plan_t> plans;
  for (const ParallelFor& parallel : {ParallelFor(serially), backwards}) {
    test::NodeBench b(NodeId::kController, make_controller_node_on(parallel, dump(e), blobs));
    b.start();
    b.give(channels::kHeightMap, m);
    plans.push_back(b.last(channels::kLayerPlan));
  }
  CHECK(calls > 0);
  CHECK(plans[0].drops == plans[1].drops);
  CHECK(plans[0].objective_mm == plans[1].objective_mm);
}

TEST_CASE(
    "Two inks by strips through the node: each cell's ink is sent, and no droplet search finds a better "
    "layer") {
  Experiment e = small("mpc");
  e.grid.nx = 24;
  e.grid.ny = 18;
  const Mask mask(e.grid, 1);
  std::vector<std::vector<Span>> spans(e.grid.size());
  for (std::size_t c = 0; c < spans.size(); ++c)
    if (c % 24 < 11) spans[c] = {{0.0, 0.05}};
  const auto geometry = std::make_shared<const Geometry>(e.grid, 0.05, spans);
  HeightMap h(e.grid, 0.05);
  RandomStream random(4, Purpose::kTest);
  for (double& v : h.cells) v -= random.uniform(0.0, 0.0076);
  height_map_t m{};
  m.map_id = 1;
  set_height(m, h);
  m.quality.assign(h.size(), 0);
  double last = 1.0;
  for (const auto method :
       {control::MpcMethod::kGreedy, control::MpcMethod::kStripDp, control::MpcMethod::kCertified}) {
    e.control.mpc.method = method;
    test::NodeBench b(NodeId::kController,
                      std::make_unique<ControllerNode>(e, HeightMap(e.grid, 0.05), mask, geometry));
    b.start();
    b.give(channels::kHeightMap, m);
    const layer_plan_t plan = b.last(channels::kLayerPlan);
    REQUIRE(plan.material.size() == h.size());
    for (std::size_t c = 0; c < h.size(); ++c) CHECK(int(plan.material[c]) == (c % 24 >= 11 ? 2 : 1));
    CHECK(plan.objective_mm < plan.objective_none_mm);
    CHECK(plan.objective_mm <= last);
    last = plan.objective_mm;
  }
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
