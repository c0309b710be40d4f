#include "procs/droplet_estimator/node.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/grid/npy.h"
#include "firn/droplet_sweep_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_model_t.hpp"
#include "lcmtypes/convert.h"
#include "lcmtypes/validate.h"
#include "tests/estimators/planted.h"
#include "tests/support/node_bench.h"

namespace firn {
namespace {

Experiment small_experiment() {
  Experiment e;
  e.grid = {16, 14, 0.25, 0.25, 1.0, -2.0};
  e.estimator.droplets = "on";
  return e;
}

// The node and a planted world that prints and measures for it.
struct EstimatorBench : test::NodeBench {
  EstimatorBench()
      : NodeBench(NodeId::kDropletEstimator, std::make_unique<DropletEstimatorNode>(
                                                 small_experiment(), Mask(small_experiment().grid, 1))) {
    world.grid = small_experiment().grid;
    world.height = HeightMap(world.grid, 0.0);
    world.model = {4.8e-3, 0.5e-3, 0.25e-3};
    world.noise_mm = 0.0002;
    start();
  }
  void map(int layer, int attempt = 0, float lift_mm = 0.0F) {
    height_map_t m{};
    m.layer = layer;
    m.attempt = attempt;
    m.map_id = ++maps;
    m.noise_std_mm = world.noise_mm;
    set_height(m, world.measure());
    for (float& z : m.height_mm) z += lift_mm;
    m.quality.assign(m.height_mm.size(), 0);
    give(channels::kHeightMap, m);
  }
  deposition_report_t report() {
    const droplet::Pass pass = world.print();
    deposition_report_t r{};
    r.layer = world.layer;
    r.passes = 1;
    r.material = std::int8_t(Material::kA);
    r.sub_patterns = 1;
    r.cured = 1;
    r.outcome = std::int8_t(Outcome::kDone);
    r.grid = to_message(world.grid);
    r.n = std::int32_t(world.grid.size());
    r.drops.assign(world.grid.size(), 0);
    for (const auto c : pass.cells) r.drops[c] = 1;
    r.commanded = r.triggered_stage = r.triggered_jet = r.unknown_from = r.unknown_to =
        std::int64_t(pass.cells.size());
    r.confirmed = -1;
    return r;
  }
  void layer() {
    give(channels::kDepositionReport, report());
    map(world.layer);
  }
  std::size_t models() const { return all(channels::kHeightModel).size(); }
  std::size_t faults() const { return all(channels::fault(NodeId::kDropletEstimator)).size(); }

  test::Planted world;
  std::int64_t maps = 0;
};

}  // namespace

TEST_CASE("A model follows every map, names it, and comes near the planted one with the layers") {
  EstimatorBench b;
  b.map(0);
  CHECK(b.models() == 1);
  CHECK(b.last(channels::kHeightModel).layers_used == 0);
  CHECK(b.last(channels::kHeightModel).h1_mm == small_experiment().model.h1_mm);
  for (int k = 1; k <= 5; ++k) {
    b.layer();
    const height_model_t m = b.last(channels::kHeightModel);
    CHECK(m.layer == k);
    CHECK(m.map_id == b.maps);
    CHECK(m.layers_used == k);
  }
  const height_model_t m = b.last(channels::kHeightModel);
  CHECK(m.h1_mm == Approx(b.world.model.h1_mm).epsilon(0.03));
  CHECK(m.layer_height_mm == Approx(b.world.model.layer_height_mm()).epsilon(0.03));
  CHECK(m.layer_height_mm == Approx(m.h1_mm + 4 * m.h2_mm + 4 * m.h3_mm));
  CHECK(m.covariance_mm2[0] > 0.0);
  CHECK(m.excitation > 0.0);
  CHECK(b.faults() == 0);
  for (const auto& s : b.sent) CHECK_FALSE(validate(*find_channel(s.channel), s.bytes));
}

TEST_CASE(
    "A map that overtakes the report of its layer waits for it, and the result is the same to the last "
    "byte") {
  EstimatorBench in_order, overtaken;
  in_order.map(0);
  overtaken.map(0);
  for (int k = 1; k <= 3; ++k) {
    in_order.layer();
    const deposition_report_t late = overtaken.report();
    overtaken.map(k);
    CHECK(overtaken.models() == std::size_t(k));
    overtaken.give(channels::kDepositionReport, late);
    CHECK(overtaken.models() == std::size_t(k + 1));
  }
  CHECK(in_order.last(channels::kHeightModel).h2_mm == overtaken.last(channels::kHeightModel).h2_mm);
  CHECK(in_order.last(channels::kHeightModel).map_id == overtaken.last(channels::kHeightModel).map_id);
}

TEST_CASE("The droplets' volume in a sweep is the estimator's prior before the first layer") {
  Experiment e = small_experiment();
  e.estimator.droplets = "camera";
  test::NodeBench bench(NodeId::kDropletEstimator,
                        std::make_unique<DropletEstimatorNode>(e, Mask(e.grid, 1)));
  bench.start();
  droplet_sweep_t sweep{};
  sweep.known = std::int32_t(SweepValue::kVolume);
  sweep.volume_mm3 = 0.006 * e.grid.pitch_x_mm * e.grid.pitch_y_mm;
  sweep.volume_std_mm3 = 0.01 * sweep.volume_mm3;
  bench.give(channels::kDropletSweep, sweep);
  height_map_t m{};
  m.map_id = 1;
  m.noise_std_mm = 0.0002;
  set_height(m, HeightMap(e.grid, 0.0));
  m.quality.assign(m.height_mm.size(), 0);
  bench.give(channels::kHeightMap, m);
  const auto models = bench.all(channels::kHeightModel);
  REQUIRE(models.size() == 1);
  CHECK(models[0].layer_height_mm == Approx(0.006).epsilon(0.02));
  CHECK(models[0].layer_height_std_mm == Approx(0.006 * std::hypot(0.01, 0.03)).epsilon(0.05));
}

TEST_CASE("A layer that is measured again replaces what its first map taught") {
  EstimatorBench b, clean;
  b.map(0);
  clean.map(0);
  b.layer();
  clean.layer();
  b.give(channels::kDepositionReport, b.report());
  b.map(2, 0, 0.005F);
  b.map(2, 1);
  clean.layer();
  CHECK(b.last(channels::kHeightModel).attempt == 1);
  CHECK(b.last(channels::kHeightModel).layers_used == 2);
  CHECK(b.last(channels::kHeightModel).h1_mm ==
        Approx(clean.last(channels::kHeightModel).h1_mm).epsilon(0.01));
}

TEST_CASE("Messages of another grid, maps without a reading and late reports change nothing but a warning") {
  EstimatorBench b;
  b.map(0);
  height_map_t other{};
  set_height(other, HeightMap(GridSpec{3, 3, 0.25, 0.25, 0.0, 0.0}, 0.0));
  other.quality.assign(9, 0);
  other.layer = 1;
  b.give(channels::kHeightMap, other);
  CHECK(b.faults() == 1);
  CHECK(Severity(b.last(channels::fault(NodeId::kDropletEstimator)).severity) == Severity::kWarning);
  const deposition_report_t first = b.report();
  b.give(channels::kDepositionReport, first);
  height_map_t blind{};
  blind.layer = 1;
  set_height(blind, HeightMap(b.world.grid, kNotMeasured));
  blind.quality.assign(b.world.grid.size(), 1);
  b.give(channels::kHeightMap, blind);
  CHECK(b.faults() == 2);
  CHECK(b.models() == 1);
  b.map(1);
  CHECK(b.models() == 2);
  const double h1 = b.last(channels::kHeightModel).h1_mm;
  b.give(channels::kDepositionReport, first);
  CHECK(b.models() == 2);
  CHECK(b.last(channels::kHeightModel).h1_mm == h1);
}

TEST_CASE("The estimator's node is built from the configuration and the mask") {
  Experiment e = small_experiment();
  e.part.shape.diameter_mm = 3.0;
  CHECK(make_droplet_estimator(dump(e), {{"mask", "", to_npy(Mask(e.grid, 1))}}) != nullptr);
  CHECK_THROWS_WITH(make_droplet_estimator(dump(e), {}), Catch::Contains("mask"));
}

}  // namespace firn
