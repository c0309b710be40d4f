#include "core/control/auto/auto_scheme.h"

#include <catch2/catch.hpp>

#include "core/control/graph/graph_layer.h"
#include "core/control/prediction.h"
#include "core/grid/random.h"
#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;

namespace {

Setup auto_setup() { return cylinder_setup(21.0, 0.06); }

ControlOptions auto_options_of_experiment() {
  ControlOptions o;
  o.scheme = "auto";
  return o;
}

DropletPattern random_drops(const Setup& s, std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  DropletPattern drops(s.grid);
  for (std::size_t c = 0; c < drops.size(); ++c) drops.cells[c] = s.mask.cells[c] && random.uniform() < 0.6;
  return drops;
}

HeightMap rough(const Setup& s, std::uint64_t seed, double size_mm) {
  RandomStream random(seed, Purpose::kTest);
  HeightMap h(s.grid);
  for (double& v : h.cells) v = random.uniform(0.0, size_mm);
  return h;
}

/// A layer whose cells rise by chance, whatever is fired.
LayerSign by_chance(const Setup& s, std::uint64_t seed) {
  const HeightMap before = rough(s, seed, 0.004);
  HeightMap after = before;
  RandomStream random(seed + 100, Purpose::kTest);
  for (double& v : after.cells) v += random.uniform(0.0, 0.008);
  return sign_of_layer(s, before, random_drops(s, seed), {}, after, int(seed), 0.0);
}

LayerSign by_law(const Setup& s, std::uint64_t seed, double noise_mm = 0.0) {
  const HeightMap before = rough(s, seed, 0.004);
  const DropletPattern drops = random_drops(s, seed);
  Predictor law(s);
  return sign_of_layer(s, before, drops, {}, law.after(before, drops), int(seed), noise_mm);
}

LabSigns signs_of(const std::vector<LayerSign>& layers) {
  LabSigns signs(deposition::DropletModel{}.layer_height_mm());
  for (const LayerSign& s : layers) signs.add(s);
  return signs;
}

constexpr double kDroplet_mm = 0.0076;

}  // namespace

TEST_CASE("Layers that follow the height-change model are explained by it") {
  const Setup s = auto_setup();
  const LabSigns signs = signs_of({by_law(s, 1), by_law(s, 2)});
  REQUIRE(signs.judged());
  CHECK(signs.explained(JudgedModel::kFlow) == Approx(1.0));
  CHECK(signs.better_model() == JudgedModel::kFlow);
}

TEST_CASE("Layers that flow along a graph are explained better by the graph model") {
  const Setup s = auto_setup();
  LabSigns signs(kDroplet_mm);
  for (std::uint64_t n = 1; n <= 3; ++n) {
    const HeightMap before = rough(s, n, 0.02);
    const DropletPattern drops = random_drops(s, n);
    HeightMap after = before;
    std::vector<double> dose(drops.cells.begin(), drops.cells.end());
    graph::layer_along(graph::GraphModel(s.model, s.border, 1), s.grid,
                       std::vector<double>(s.grid.size(), kDroplet_mm), after.cells, dose);
    signs.add(sign_of_layer(s, before, drops, {}, after, int(n), 0.0));
  }
  CHECK(signs.explained(JudgedModel::kGraph) == Approx(1.0));
  CHECK(signs.better_model() == JudgedModel::kGraph);
}

TEST_CASE("Layers that rise by chance are explained by no model") {
  const Setup s = auto_setup();
  const LabSigns signs = signs_of({by_chance(s, 1), by_chance(s, 2), by_chance(s, 3)});
  REQUIRE(signs.judged());
  CHECK(signs.explained(signs.better_model()) < 0.0);
}

TEST_CASE("Full layers on level ground tell nothing of a model") {
  const Setup s = auto_setup();
  HeightMap before(s.grid, 0.0), after(s.grid, kDroplet_mm);
  DropletPattern drops(s.grid);
  for (std::size_t c = 0; c < drops.size(); ++c) drops.cells[c] = s.mask.cells[c];
  const LayerSign full = sign_of_layer(s, before, drops, {}, after, 1, 0.0);
  CHECK_FALSE(signs_of({full, full, full}).judged());
}

TEST_CASE("Rises that differ by less than the noise of two maps tell nothing of a model") {
  const Setup s = auto_setup();
  CHECK(signs_of({by_law(s, 1), by_law(s, 2)}).judged());
  CHECK_FALSE(signs_of({by_law(s, 1, 0.01), by_law(s, 2, 0.01)}).judged());
}

TEST_CASE("Signs forget layers beyond their window") {
  const Setup s = auto_setup();
  std::vector<LayerSign> layers{by_chance(s, 1), by_chance(s, 2)};
  for (int n = 0; n < LabSigns::kWindow; ++n) layers.push_back(by_law(s, 10 + std::uint64_t(n)));
  CHECK(signs_of(layers).explained(JudgedModel::kFlow) == Approx(1.0));
}

TEST_CASE("With an estimate auto begins with strips that rise together") {
  CHECK(auto_rule(signs_of({}), kDroplet_mm, true, {}).choice == AutoChoice::kTogether);
}

TEST_CASE("Without an estimate auto takes strips on the map where noise is low, and SMF where it is high") {
  const auto choice = [](double noise_mm, std::optional<AutoChoice> now) {
    return auto_rule(signs_of({LayerSign{1, noise_mm}}), kDroplet_mm, false, now).choice;
  };
  CHECK(choice(0.1 * kDroplet_mm, {}) == AutoChoice::kStrips);
  CHECK(choice(0.3 * kDroplet_mm, {}) == AutoChoice::kSmf);
  CHECK(choice(0.17 * kDroplet_mm, AutoChoice::kSmf) == AutoChoice::kSmf);
  CHECK(choice(0.17 * kDroplet_mm, AutoChoice::kStrips) == AutoChoice::kStrips);
}

TEST_CASE("Where no model holds auto takes threshold feedback, and leaves it where one holds clearly") {
  const Setup s = auto_setup();
  const LabSigns none = signs_of({by_chance(s, 1), by_chance(s, 2)}),
                 law = signs_of({by_law(s, 1), by_law(s, 2)});
  for (const bool estimate : {false, true})
    CHECK(auto_rule(none, kDroplet_mm, estimate, AutoChoice::kTogether).choice == AutoChoice::kThreshold);
  CHECK(auto_rule(law, kDroplet_mm, true, AutoChoice::kThreshold).choice == AutoChoice::kTogether);
}

TEST_CASE("auto decides as the scheme that it has chosen") {
  const Setup s = auto_setup();
  ControlOptions strips = auto_options(AutoChoice::kStrips, {}, s.model);
  const HeightMap h = rough(s, 3, 0.004);
  const Decision a = make_controller(s, auto_options_of_experiment())->decide({h, 0, 0, 0.0003});
  CHECK(a.drops == make_controller(s, strips)->decide({h, 0, 0, 0.0003}).drops);
  CHECK_THAT(a.reason, Catch::Contains("auto: MPC of strips on the map"));
}

TEST_CASE("auto decides on the estimate where there is one") {
  const Setup s = auto_setup();
  ControlOptions together = auto_options(AutoChoice::kTogether, {}, s.model);
  const HeightMap map = rough(s, 3, 0.004), estimate = rough(s, 4, 0.004);
  CHECK(make_controller(s, auto_options_of_experiment())
            ->decide({map, 0, 0, 0.0003, &estimate, 0.0001})
            .drops == make_controller(s, together)->decide({estimate, 0, 0, 0.0001}).drops);
}

TEST_CASE("auto tells when the models are judged first and when it changes, and no more often") {
  const Setup s = auto_setup();
  const auto scheme = make_controller(s, auto_options_of_experiment());
  Predictor law(s);
  HeightMap h(s.grid);
  std::vector<std::string> notices;
  RandomStream random(9, Purpose::kTest);
  for (int layer = 0; layer < 14; ++layer) {
    const Decision d = scheme->decide({h, layer, 0, 0.0001});
    if (!d.notice.empty()) notices.push_back(d.notice);
    if (d.kind != Decision::Kind::kPrint) break;
    if (layer < 4)
      h = law.after(h, d.drops);
    else
      for (double& v : h.cells) v += random.uniform(-0.004, 0.008);  // no model holds any more
  }
  REQUIRE_FALSE(notices.empty());
  CHECK(notices.size() <= 3);
  CHECK_THAT(notices.back(), Catch::Contains("from now on threshold"));
}

TEST_CASE("auto decides a layer that is measured again as if the first time had not been") {
  const Setup s = auto_setup();
  const auto once = make_controller(s, auto_options_of_experiment()),
             twice = make_controller(s, auto_options_of_experiment());
  HeightMap h(s.grid);
  Predictor law(s);
  for (int layer = 0; layer < 5; ++layer) {
    const HeightMap wild = rough(s, 50 + std::uint64_t(layer), 0.05);
    const Decision a = once->decide({h, layer, 0, 0.0001});
    twice->decide({wild, layer, 0, 0.004});
    const Decision b = twice->decide({h, layer, 1, 0.0001});
    CHECK(a.reason == b.reason);
    CHECK(a.notice == b.notice);
    h = law.after(h, a.drops);
  }
}

TEST_CASE("auto refuses places inside cells, which its schemes do not know") {
  Setup s = auto_setup();
  s.offsets = deposition::offset_model(s.model, OffsetTable({OffsetKind::kX, 2, 1}), {}, 0.0);
  CHECK_THROWS_WITH(make_controller(s, auto_options_of_experiment()), Catch::Contains("actuation.offsets"));
}

TEST_CASE("The target's offset moves the estimate as it moves the map") {
  const Setup s = auto_setup();
  ControlOptions higher = auto_options_of_experiment();
  higher.target_offset_mm = 0.01;
  HeightMap h(s.grid, 0.06), estimate(s.grid, 0.06);
  CHECK(make_controller(s, auto_options_of_experiment())->decide({h, 8, 0, 0.0001, &estimate, 0.0001}).kind ==
        Decision::Kind::kEnd);
  CHECK(make_controller(s, higher)->decide({h, 8, 0, 0.0001, &estimate, 0.0001}).kind ==
        Decision::Kind::kPrint);
}
