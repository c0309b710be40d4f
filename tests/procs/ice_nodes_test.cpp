// path_planner, surface_mapper and controller of lab.kind "ice", each by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/slice/coverage/footprint.h"
#include "firn/control_surface_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/flow_model_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/laser_samples_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/preview_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "firn/trajectory_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/controller/node.h"
#include "procs/controller/surface_node.h"
#include "procs/flow_estimator/node.h"
#include "procs/path_planner/node.h"
#include "procs/surface_mapper/path_mapper.h"
#include "tests/procs/ice_readings.h"
#include "tests/support/ice_print.h"
#include "tests/support/node_bench.h"

namespace firn {
namespace {

using test::NodeBench;
using test::readings;

NodeBench planner(const Experiment& e = test::ice_experiment(), slice::PrintPaths paths = test::ice_print()) {
  return {NodeId::kPathPlanner, std::make_unique<PathPlannerNode>(e, test::cobra(), std::move(paths))};
}
NodeBench mapper(const Experiment& e = test::ice_experiment()) {
  return {NodeId::kSurfaceMapper, std::make_unique<PathMapper>(e, test::cobra(), test::ice_print())};
}
NodeBench controller(const Experiment& e = test::ice_experiment()) {
  return {NodeId::kController, std::make_unique<SurfaceControllerNode>(e, test::ice_print())};
}

control_surface_t action(int layer, double u, int attempt = 0, int decision = 0) {
  control_surface_t s{};
  s.layer = layer;
  s.attempt = attempt;
  s.map_id = 10 + layer + attempt;
  s.decision = std::int8_t(decision);
  const GridSpec g = slice::footprint_grid(*slice::find_layer(test::ice_print(), layer), 1.0);
  s.grid = to_message(g);
  s.n = std::int32_t(g.size());
  s.u.assign(g.size(), float(u));
  s.feed_forward[0] = s.feed_forward[1] = 1.0;
  return s;
}

height_map_t flat_map(int layer, double off_mm, double measured = 1.0) {
  const slice::PrintPaths paths = test::ice_print();
  const slice::LayerPaths& l = *slice::find_layer(paths, layer);
  height_map_t m{};
  m.layer = layer;
  m.map_id = layer;
  m.measured_fraction = measured;
  set_height(m, HeightMap(slice::footprint_grid(l, 1.0), 0.24 * layer + off_mm));
  m.quality.assign(m.height_mm.size(), 0);
  return m;
}

double hill(double x, double y) { return 1.2 + 0.1 * std::sin(0.15 * x) + 0.002 * y; }

}  // namespace

TEST_CASE(
    "path_planner: at the start the first interval, layer by layer, then the paths that measure its last "
    "layer") {
  NodeBench b = planner();
  b.start();
  const auto jobs = b.all(channels::kPathJob);
  const auto motions = b.all(channels::kTrajectory);
  REQUIRE(jobs.size() > 50);
  REQUIRE(motions.size() == jobs.size());
  std::map<std::int64_t, std::int64_t> pulses;
  for (const pulse_list_t& l : b.all(channels::kPulseList)) pulses[l.path] += l.n;
  int layer = 1;
  bool measuring = false;
  for (std::size_t n = 0; n < jobs.size(); ++n) {
    const path_job_t& j = jobs[n];
    CHECK(j.text.empty());
    CHECK(j.batch == 1);
    CHECK(j.index == int(n));
    CHECK(j.count == int(jobs.size()));
    CHECK(j.path == std::int64_t(n + 1));
    CHECK(motions[n].path == j.path);
    CHECK(j.duration_s == motions[n].duration_s);
    CHECK(j.layer >= layer);
    layer = j.layer;
    if (j.kind == std::int8_t(PathKind::kMeasurement)) measuring = true;
    CHECK((j.kind == std::int8_t(PathKind::kMeasurement)) == measuring);
    CHECK(j.valve == (measuring ? 0 : j.material == 0 ? 1 : 2));
    CHECK(pulses[j.path] == j.pulses);
    CHECK((j.pulses > 0) == !measuring);
    CHECK(j.z_mm == Approx(measuring ? 1.2 : 0.24 * j.layer + 3.0));
    CHECK(j.x_min_mm >= -15.3);
    CHECK(j.x_max_mm <= 15.3);
  }
  CHECK(measuring);
  CHECK(layer == 5);
}

TEST_CASE(
    "path_planner: a surface brings the next interval, planned with it, and again for another attempt, never "
    "for an old one") {
  Experiment e = test::ice_experiment();
  e.control.surface.version = control::SurfaceVersion::kValveFrequency;
  NodeBench b = planner(e);
  b.start();
  while (b.wake()) {
  }
  const std::size_t first = b.all(channels::kPathJob).size();
  b.give(channels::kControlSurface, action(5, 0.2));
  auto jobs = b.all(channels::kPathJob);
  REQUIRE(jobs.size() == 2 * first);
  double nominal = 0.0, more = 0.0;
  std::int64_t last_path = 0;
  for (const path_job_t& j : jobs) {
    CHECK(j.path > last_path);
    last_path = j.path;
    if (j.batch == 2) CHECK(j.layer > 5);
    if (j.batch == 2) CHECK(j.map_id == 15);
    if (j.kind != std::int8_t(PathKind::kMeasurement)) (j.batch == 1 ? nominal : more) += j.volume_mm3;
  }
  CHECK(more == Approx(1.2 * nominal).epsilon(1e-3));
  b.give(channels::kControlSurface, action(5, 0.2));
  CHECK(b.all(channels::kPathJob).size() == 2 * first);
  b.give(channels::kControlSurface, action(5, 0.0, 1));
  CHECK(b.all(channels::kPathJob).size() == 3 * first);
  CHECK(b.last(channels::kPathJob).batch == 3);
  b.give(channels::kControlSurface, action(10, 0.0));  // nothing above
  CHECK(b.all(channels::kPathJob).size() == 3 * first);
  b.give(channels::kControlSurface, action(5, 0.0, 2, 1));
  CHECK(b.all(channels::kPathJob).size() == 3 * first);
}

TEST_CASE(
    "with ice.map_table the table comes first: its paths alone, its map on the first interval's grid, its "
    "action, and no lesson for the flow") {
  Experiment e = test::ice_experiment();
  e.ice.map_table = "on";
  NodeBench plan = planner(e);
  plan.start();
  const auto table = plan.all(channels::kPathJob);
  const auto motions = plan.all(channels::kTrajectory);
  REQUIRE(!table.empty());
  for (const path_job_t& j : table) {
    CHECK(j.kind == std::int8_t(PathKind::kMeasurement));
    CHECK(j.layer == 0);
    CHECK(j.z_mm == Approx(0.0));
    CHECK(j.batch == 1);
    CHECK(j.count == int(table.size()));
  }

  NodeBench map = mapper(e);
  map.start();
  for (std::size_t n = 0; n < motions.size(); ++n) {
    map.give(channels::kTrajectory, motions[n]);
    map.give(channels::kLaserSamples,
             readings(
                 motions[n], test::ice_experiment().laser_point.latency_s,
                 [](double x, double y) { return 0.02 * x - 0.01 * y; }, int(n), int(motions.size()), 1));
  }
  REQUIRE(map.all(channels::kHeightMap).size() == 1);
  const height_map_t bare = map.last(channels::kHeightMap);
  CHECK(bare.layer == 0);
  CHECK(from_message(bare.grid) == slice::footprint_grid(*slice::find_layer(test::ice_print(), 5), 1.0));
  CHECK(bare.measured_fraction > 0.95);
  const HeightMap height = height_of(bare);
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (bare.quality[c]) continue;
    const double x = height.spec.x_mm(int(c) % height.spec.nx), y = height.spec.y_mm(int(c) / height.spec.nx);
    REQUIRE(height.cells[c] == Approx(0.02 * x - 0.01 * y).margin(0.01));
  }

  NodeBench law = controller(e);
  law.start();
  law.give(channels::kHeightMap, bare);
  REQUIRE(law.all(channels::kControlSurface).size() == 1);
  const control_surface_t u = law.last(channels::kControlSurface);
  CHECK(u.layer == 0);
  CHECK(u.decision == 0);
  CHECK(u.mean_error_mm == Approx(0.0).margin(0.05));
  plan.give(channels::kControlSurface, u);
  const auto jobs = plan.all(channels::kPathJob);
  REQUIRE(jobs.size() > table.size());
  CHECK(jobs[table.size()].layer == 1);
  CHECK(jobs[table.size()].map_id == bare.map_id);
  CHECK(jobs.back().layer == 5);

  NodeBench flow(NodeId::kFlowEstimator,
                 std::make_unique<FlowEstimatorNode>(e, test::cobra(), test::ice_print()));
  flow.start();
  flow.give(channels::kHeightMap, bare);
  CHECK(flow.all(channels::kFlowModel).empty());
}

TEST_CASE(
    "path_planner: in the speed version more material means slower paths, as long as the arm reaches their "
    "speed") {
  NodeBench b = planner();
  b.start();
  const std::size_t first = b.all(channels::kPathJob).size();
  b.give(channels::kControlSurface, action(5, 0.4));
  const auto jobs = b.all(channels::kPathJob);
  for (std::size_t n = 0; n < first; ++n) {
    if (jobs[n].kind == std::int8_t(PathKind::kMeasurement)) continue;
    CHECK(jobs[first + n].volume_mm3 == Approx(1.4 * jobs[n].volume_mm3).epsilon(1e-3));
    if (jobs[n].length_mm < 60.0) continue;
    CHECK(jobs[first + n].duration_s > 1.2 * jobs[n].duration_s);
    CHECK(double(jobs[first + n].pulses) / jobs[first + n].duration_s ==
          Approx(double(jobs[n].pulses) / jobs[n].duration_s).epsilon(0.1));
  }
}

TEST_CASE(
    "path_planner: a path out of reach anywhere in the print is refused by name before anything is planned") {
  slice::PrintPaths paths = test::ice_print();
  test::add_rings(paths.layers[8], 700.0, 698.0, 2.0, PathKind::kBoundary, 0);
  NodeBench b = planner(test::ice_experiment(), paths);
  b.start();
  CHECK(b.all(channels::kTrajectory).empty());
  REQUIRE(b.all(channels::kPathJob).size() == 1);
  CHECK(b.last(channels::kPathJob).text.find("layer 9, deposition path 11: ") == 0);
  CHECK(b.last(channels::kPathJob).text.find("reach") != std::string::npos);
  const fault_t f = b.last(channels::fault(NodeId::kPathPlanner));
  CHECK(f.severity == std::int8_t(Severity::kStop));
  CHECK(f.text.find("layer 9") != std::string::npos);
}

TEST_CASE("path_planner: after a resume nothing of what was sent is sent again") {
  NodeBench b = planner();
  b.start(1);
  CHECK(b.sent.empty());
}

TEST_CASE(
    "surface_mapper: the readings of all paths become the map of the layer's own grid, in any order, once") {
  NodeBench plan = planner();
  plan.start();
  std::vector<trajectory_t> motions;
  for (const trajectory_t& t : plan.all(channels::kTrajectory))
    if (t.kind == std::int8_t(PathKind::kMeasurement)) motions.push_back(t);
  REQUIRE(motions.size() >= 6);
  std::vector<float> forward;
  for (const bool backward : {false, true}) {
    NodeBench b = mapper();
    b.start();
    const int n = int(motions.size());
    for (int k = 0; k < n; ++k) {
      const int at = backward ? n - 1 - k : k;
      const laser_samples_t s = readings(motions[std::size_t(at)], 0.03, hill, at, n, 7);
      if (backward) b.give(channels::kLaserSamples, s);
      b.give(channels::kTrajectory, motions[std::size_t(at)]);
      if (!backward) b.give(channels::kLaserSamples, s);
      b.give(channels::kLaserSamples, s);  // twice
    }
    REQUIRE(b.all(channels::kHeightMap).size() == 1);
    const height_map_t m = b.last(channels::kHeightMap);
    CHECK(m.layer == 5);
    CHECK(from_message(m.grid) == slice::footprint_grid(*slice::find_layer(test::ice_print(), 5), 1.0));
    CHECK(m.measured_fraction > 0.98);
    CHECK(b.all(channels::kHeightPreview).size() == 1);
    const HeightMap h = height_of(m);
    int measured = 0;
    for (int j = 0; j < h.spec.ny; ++j)
      for (int i = 0; i < h.spec.nx; ++i) {
        if (m.quality[h.spec.index(i, j)] != std::int8_t(CellQuality::kMeasured)) continue;
        ++measured;
        CHECK(h.at(i, j) == Approx(hill(h.spec.x_mm(i), h.spec.y_mm(j))).margin(0.004));
      }
    CHECK(measured > 700);
    if (backward) CHECK(m.height_mm == forward);
    forward = m.height_mm;
  }
}

TEST_CASE(
    "surface_mapper: values that are missing show in measured_fraction, and an older scan is dropped for a "
    "newer one") {
  NodeBench plan = planner();
  plan.start();
  std::vector<trajectory_t> motions;
  for (const trajectory_t& t : plan.all(channels::kTrajectory))
    if (t.kind == std::int8_t(PathKind::kMeasurement)) motions.push_back(t);
  NodeBench b = mapper();
  b.start();
  for (const trajectory_t& t : motions) b.give(channels::kTrajectory, t);
  const int n = int(motions.size());
  b.give(channels::kLaserSamples, readings(motions[0], 0.03, hill, 0, n, 1));
  for (int k = 0; k < n; ++k) {
    laser_samples_t s = readings(motions[std::size_t(k)], 0.03, hill, k, n, 2);
    for (std::size_t i = 0; i < s.distance_mm.size(); i += 3) s.distance_mm[i] = float(kNotMeasured);
    b.give(channels::kLaserSamples, s);
  }
  b.give(channels::kLaserSamples, readings(motions[1], 0.03, hill, 1, n, 1));
  REQUIRE(b.all(channels::kHeightMap).size() == 1);
  CHECK(b.last(channels::kHeightMap).measured_fraction == Approx(2.0 / 3.0).margin(0.02));
  CHECK(b.last(channels::fault(NodeId::kSurfaceMapper)).text.find("scan 1 was left unfinished") == 0);
  for (int k = 0; k < n; ++k) {
    laser_samples_t s = readings(motions[std::size_t(k)], 0.03, hill, k, n, 3);
    std::fill(s.distance_mm.begin(), s.distance_mm.end(), float(kNotMeasured));
    b.give(channels::kLaserSamples, s);
  }
  REQUIRE(b.all(channels::kHeightMap).size() == 2);
  CHECK(b.last(channels::kHeightMap).measured_fraction == 0.0);
}

TEST_CASE("controller: a map is answered with the action on its grid, and the last layer ends the print") {
  NodeBench b = controller();
  b.start();
  b.give(channels::kHeightMap, flat_map(5, -0.06));
  const control_surface_t s = b.last(channels::kControlSurface);
  CHECK(s.layer == 5);
  CHECK(s.map_id == 5);
  CHECK(s.decision == 0);
  CHECK(s.version == std::int8_t(ControlVersion::kPathSpeed));
  CHECK(s.rms_mm == Approx(0.06).epsilon(1e-4));
  CHECK(s.mean_error_mm == Approx(-0.06).epsilon(1e-4));
  const GridSpec g = from_message(s.grid);
  CHECK(double(s.u[g.index(g.nx / 2, g.ny / 2)]) == Approx(1.25 * 0.05).epsilon(1e-4));
  b.give(channels::kHeightMap, flat_map(10, 0.0));
  CHECK(b.last(channels::kControlSurface).decision == 1);
}

TEST_CASE(
    "controller: a map with too few readings is not answered, one that cannot be used stops the print by "
    "name") {
  NodeBench b = controller();
  b.start();
  b.give(channels::kHeightMap, flat_map(5, 0.0, 0.79));
  CHECK(b.all(channels::kControlSurface).empty());
  height_map_t wrong = flat_map(5, 0.0);
  wrong.grid.origin_x_mm += 0.5;
  b.give(channels::kHeightMap, wrong);
  CHECK(b.last(channels::kControlSurface).decision == 2);
  CHECK(b.last(channels::fault(NodeId::kController)).text.find("is not layer 5's") != std::string::npos);
  height_map_t unknown = flat_map(5, 0.0);
  unknown.layer = 11;
  b.give(channels::kHeightMap, unknown);
  CHECK(b.last(channels::kControlSurface).reason.find("no layer 11") != std::string::npos);
  b.give(channels::kHeightMap, flat_map(5, 0.0));
  CHECK(b.last(channels::kControlSurface).decision == 0);
}

TEST_CASE(
    "controller: with feed-forward the learned flow of each valve is divided out, and a map waits for what "
    "it taught of them") {
  Experiment e = test::ice_experiment();
  e.flow.feed_forward = "on";
  flow_model_t f{}, older{};
  f.map_id = 5;
  f.factor[0] = 1.1;
  f.factor[1] = 0.95;
  f.maps_used = older.maps_used = 3;
  older.map_id = 4;
  older.factor[0] = older.factor[1] = 1.3;
  for (const bool overtakes : {false, true}) {
    NodeBench b = controller(e);
    b.start();
    b.give(channels::kFlowModel, older);
    if (overtakes) b.give(channels::kFlowModel, f);
    b.give(channels::kHeightMap, flat_map(5, 0.0));
    CHECK(b.all(channels::kControlSurface).size() == (overtakes ? 1 : 0));
    if (!overtakes) b.give(channels::kFlowModel, f);
    REQUIRE(b.all(channels::kControlSurface).size() == 1);
    const control_surface_t s = b.last(channels::kControlSurface);
    const GridSpec g = from_message(s.grid);
    CHECK(double(s.u[g.index(g.nx / 2, g.ny / 2)]) == Approx(1.0 / 1.1 - 1.0).epsilon(1e-4));
    CHECK(s.feed_forward[0] == Approx(1.0 / 1.1));
    CHECK(s.feed_forward[1] == Approx(1.0 / 0.95));
  }
}

TEST_CASE(
    "flow_estimator: what was laid against what rose gives each valve's factor, and paths in doubt do not "
    "count") {
  NodeBench plan = planner();
  plan.start();
  for (const bool doubt : {false, true}) {
    NodeBench b{NodeId::kFlowEstimator, std::make_unique<FlowEstimatorNode>(
                                            test::ice_experiment(), test::cobra(), test::ice_print())};
    b.start();
    const auto motions = plan.all(channels::kTrajectory);
    const auto jobs = plan.all(channels::kPathJob);
    const auto lists = plan.all(channels::kPulseList);
    for (std::size_t n = 0; n < jobs.size(); ++n) {
      path_report_t r{};
      r.path = jobs[n].path;
      r.batch = 1;
      r.layer = jobs[n].layer;
      r.material = jobs[n].material;
      r.kind = jobs[n].kind;
      r.outcome = std::int8_t(doubt && jobs[n].material == 0 ? Outcome::kUnknown : Outcome::kDone);
      r.pulses_commanded = r.pulses_counted = jobs[n].pulses;
      if (n % 3 == 0) b.give(channels::kPathReport, r);  // overtakes its path
      b.give(channels::kTrajectory, motions[n]);
      for (const pulse_list_t& l : lists)
        if (l.path == r.path) b.give(channels::kPulseList, l);
      if (n % 3 != 0) b.give(channels::kPathReport, r);
    }
    const height_map_t poor = flat_map(5, 0.12, 0.5);
    b.give(channels::kHeightMap, poor);
    CHECK(b.all(channels::kFlowModel).empty());
    b.give(channels::kHeightMap, flat_map(5, 0.12));  // a tenth too high
    const flow_model_t f = b.last(channels::kFlowModel);
    CHECK(f.layer == 5);
    CHECK(f.maps_used == 1);
    CHECK(f.factor[0] == Approx(doubt ? 1.0 : 1.1).margin(doubt ? 0.02 : 0.03));
    if (!doubt) CHECK(f.factor_std[0] < 0.07);
    if (doubt) CHECK(f.factor_std[0] == Approx(0.2).epsilon(0.05));
  }
}

}  // namespace firn
