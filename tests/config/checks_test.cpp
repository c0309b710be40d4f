#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/experiment.h"

using namespace firn;

namespace {

std::string rule_broken_by(const std::string& toml) {
  try {
    parse_experiment(toml, "x.toml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no error";
}

bool says(const std::string& toml, const std::string& words) {
  const std::string what = rule_broken_by(toml);
  INFO(what);
  CHECK(what.find(words) != std::string::npos);
  return what.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("The defaults and the smallest grid pass every check") {
  CHECK(rule_broken_by("") == "no error");
  CHECK(rule_broken_by("grid.nx = 1\ngrid.ny = 1\npart.diameter_mm = 0.2") == "no error");
}

TEST_CASE("A part that does not fit the grid is named with the key, its line and the room there is") {
  CHECK(
      says("[part]\n\ndiameter_mm = 20.0",
           "x.toml:3: part.diameter_mm = 20.0 mm: the part does not fit the grid, which is 10.530 mm wide"));
  CHECK(says("[grid]\nnx = 20", "part.diameter_mm = 10.0 mm"));
  CHECK(says("part = {shape = \"cuboid\", width_mm = 5, depth_mm = 30}",
             "part.depth_mm = 30.0 mm: the part does not fit"));
  CHECK(says("part = {shape = \"cuboid\", width_mm = 5}",
             "part.depth_mm = 0.0 mm: must be above 0 mm for a cuboid"));
  CHECK(says("part = {shape = \"pipe\", inner_diameter_mm = 10.0}",
             "must lie between 0 and part.diameter_mm = 10.0 mm"));
  CHECK(says("part = {shape = \"wedge\", width_mm = 5, depth_mm = 5, low_height_mm = 0.5}",
             "must not exceed part.height_mm = 0.4 mm"));
}

TEST_CASE("A height map needs its image, and only a height map takes one") {
  CHECK(says("part.shape = \"height_map\"", "needs a PNG"));
  CHECK(says("part.image = \"a.png\"", "only part.shape \"height_map\" takes a PNG"));
  CHECK(rule_broken_by("part = {shape = \"height_map\", image = \"a.png\"}") == "no error");
}

TEST_CASE(
    "Two inks: a folder of pictures goes with geometry.shape images, and the support's sides stay below its "
    "centre") {
  CHECK(says("geometry.shape = \"images\"", "needs a folder of PNGs"));
  CHECK(says("geometry.images = \"layers\"", "only geometry.shape \"images\" takes PNGs"));
  CHECK(says("geometry.shape = \"torus\"", "pipe_junction"));
  CHECK(says("model.g2_mm = 0.005", "must not exceed model.g1_mm"));
  CHECK(says("model.g3_mm = 0.005", "must not exceed model.g1_mm"));
}

TEST_CASE("Speeds stay within the stage's and the jet's") {
  CHECK(says("process.pass_speed_mm_s = 301.0", "must not exceed stage.max_speed_mm_s = 300.0 mm/s"));
  CHECK(says("stage.max_speed_mm_s = 10.0",
             "x.toml:1: process.pass_speed_mm_s = 150.0 mm/s: must not exceed stage.max_speed_mm_s"));
  CHECK(says("jet.max_rate_hz = 500", "fires faster than jet.max_rate_hz = 500 Hz"));
}

TEST_CASE("The stage reaches the speed of a scan within one row") {
  CHECK(says(
      "process.scan_speed_mm_s = 52.0",
      "process.scan_speed_mm_s = 52.0 mm/s: needs 0.270 mm of run-up at stage.acceleration_mm_s2 = 5000.0"));
  CHECK(rule_broken_by("process.scan_speed_mm_s = 51.0") == "no error");
}

TEST_CASE("The band of the jet is a band, and the stage reaches the camera") {
  CHECK(says("camera.use = \"on\"\nwatch.velocity_least_m_s = 6.0",
             "watch.velocity_least_m_s = 6.0 m/s: must be below watch.velocity_most_m_s = 6.0 m/s"));
  const std::string gate = "camera.use = \"on\"\nwatch.gate = \"on\"\n";
  CHECK(says(gate + "watch.x_mm = 1000.0",
             "x.toml:3: watch.x_mm = 1000.0 mm: the camera needs 1000.000 mm to"));
  CHECK(says(gate + "watch.y_mm = -51.0", "outside stage.y_min_mm = -50.0 mm"));
}

TEST_CASE("Grid, run-up, scan and parking stay within the stage's limits") {
  CHECK(says("grid.origin_x_mm = 145.0", "grid.origin_x_mm = 145.0 mm: the grid with its run-up needs"));
  CHECK(says("grid.origin_y_mm = -50.0", "outside stage.y_min_mm = -50.0 mm"));
  CHECK(says("laser_profiler.offset_y_mm = 80.0", "run-up and scan"));
  CHECK(says("stage.acceleration_mm_s2 = 100.0", "run-up"));  // 112 mm of run-up
  CHECK(says("process.park_x_mm = -51.0", "parking"));
  CHECK(says("stage.z_min_mm = 60.0", "must be below stage.z_max_mm"));
  CHECK(
      says("process.nozzle_gap_mm = 51.0", "outside stage.z_min_mm = -10.0 mm to stage.z_max_mm = 50.0 mm"));
  CHECK(says("stage.array_limit = 39", "must not exceed stage.array_limit = 39"));
}

TEST_CASE("Lamp, lease, profiler line, model and run name are checked against each other") {
  CHECK(says("process.exposure_s = 21.0", "must not exceed lamp.max_on_s = 20.0 s"));
  CHECK(says("run.safety_period_s = 0.2", "at most half of run.lease_s = 0.3 s"));
  CHECK(says("laser_profiler.dx_mm = 0.0001", "needs more than 64 swaths of a grid of 10.3 mm"));
  CHECK(says("model.h2_mm = 0.005", "must not exceed model.h1_mm"));
  for (const char* bad : {"", "../x", ".hidden", "a b", "a/b"})
    CHECK(says("run.name = \"" + std::string(bad) + "\"", "run.name"));
}

TEST_CASE("Places inside cells are refused by name where the model or an estimator knows centres alone") {
  CHECK(rule_broken_by("actuation.offsets = \"grid\"") == "no error");
  CHECK(says("actuation.offsets = \"x\"\nplant.model = \"lu2015\"",
             "actuation.offsets = \"x\": plant.model = \"lu2015\" has nothing between cells"));
  CHECK(says("actuation.offsets = \"x\"\nestimator.droplets = \"on\"", "in the centres alone"));
  CHECK(says("actuation.offsets = \"x\"\ncontrol.height_estimate = \"kalman\"", "in the centres alone"));
  CHECK(says("actuation.offsets = \"y\"", "must be one of none, x, grid"));
  CHECK(says("actuation.positions_x = 9", "actuation.positions_x"));
  const std::string small = "actuation = {offsets = \"x\", small_share = 0.5}\n";
  CHECK(says("actuation.small_share = 0.5", "actuation.offsets = \"x\" or \"grid\""));
  CHECK(says(small + "jet.kind = \"microdrop\"", "one size of droplet"));
  CHECK(says(small + "jet.small_dwell_v = 99\ndevices.jet.dialect.max_abs_v = 30",
             "99.0 V is beyond the head's 30 V"));
  CHECK(rule_broken_by(small) == "no error");
  CHECK(says("actuation = {offsets = \"x\", positions_x = 2, heights_mm = [0.1, 0.2]}",
             "has 2 heights; 2 places beside the centre need 50"));
}

TEST_CASE("The stage must reach the grid under the second nozzle, when there is one") {
  CHECK(rule_broken_by("jet_b.offset_x_mm = 60.0") == "no error");
  const std::string two = "geometry = {shape = \"pipe\", outer_diameter_mm = 5.0, inner_diameter_mm = 3.0}\n";
  CHECK(rule_broken_by(two) == "no error");
  CHECK(says(two + "jet_b.offset_x_mm = 60.0", "the offset of nozzle B"));
  CHECK(says(two + "jet_b.offset_y_mm = -160.0", "outside stage.y_min_mm"));
  CHECK(says(two + "jet_b.offset_z_mm = 49.5", "the gap of nozzle B"));
  CHECK(says(two + "jet_b.max_rate_hz = 100", "jet_b.max_rate_hz"));
}
