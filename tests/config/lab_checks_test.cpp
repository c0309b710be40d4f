// Rules between keys: each broken rule is named by its first key, with its value and the reason.
#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/experiment.h"

using namespace firn;
using Catch::Contains;

namespace {

std::string lab_mistake(const std::string& toml) {
  try {
    parse_experiment(toml, "x.toml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no error";
}

/// An ice experiment that keeps every rule, with `more` behind it.
std::string ice_lab(const std::string& more) {
  return "lab.kind = \"ice\"\ncontrol.scheme = \"smf\"\nice.paths = \"gear.paths\"\nice.machine = "
         "\"m.toml\"\n"
         "control.smf.output_limit = 0.5\n" +
         more;
}

std::string two_inks(const std::string& more) { return "geometry = {shape = \"pipe\"}\n" + more; }

}  // namespace

TEST_CASE("A layer has one, two or four sub-patterns") {
  for (const char* good : {"1", "2", "4"})
    CHECK(lab_mistake("process.sub_patterns = " + std::string(good)) == "no error");
  CHECK_THAT(lab_mistake("process.sub_patterns = 3"),
             Contains("process.sub_patterns = 3: a layer has 1, 2 or 4"));
}

TEST_CASE("The number of passes of a layer fits the seven bits of a pass") {
  const std::string mpc = "control.scheme = \"mpc\"\nprocess.sub_patterns = 4\ncontrol.mpc.max_drops = ";
  for (int drops = 1; drops <= 8; ++drops)
    CHECK((lab_mistake(mpc + std::to_string(drops)) == "no error") == (4 * drops <= 127));
  const std::string smf =
      two_inks("control.scheme = \"smf\"\nprocess.sub_patterns = 4\ncontrol.smf.max_drops = ");
  CHECK(lab_mistake(smf + "15") == "no error");
  CHECK_THAT(lab_mistake(smf + "16"), Contains("process.sub_patterns") && Contains("127 passes per layer"));
  CHECK(lab_mistake("control.scheme = \"smf\"\nprocess.sub_patterns = 4\ncontrol.smf.max_drops = 16") ==
        "no error");
}

TEST_CASE("A learned droplet model needs the estimator, the estimator the raw map of one ink") {
  CHECK_THAT(lab_mistake("control.adapt_model = \"on\""),
             Contains("control.adapt_model") && Contains("learns"));
  CHECK_THAT(lab_mistake("estimator.droplets = \"on\"\ncontrol.smoothing = 1"),
             Contains("needs the raw map"));
  CHECK_THAT(lab_mistake(two_inks("estimator.droplets = \"on\"\ncontrol.smoothing = 0\n")),
             Contains("estimator.droplets") && Contains("learns one ink"));
  CHECK(lab_mistake("estimator.droplets = \"on\"\ncontrol.smoothing = 0\ncontrol.adapt_model = \"on\"") ==
        "no error");
}

TEST_CASE("The Kalman map needs the raw map of one ink, and droplet factors need the Kalman map") {
  const std::string kalman = "control.height_estimate = \"kalman\"\n";
  CHECK_THAT(lab_mistake(kalman + "control.smoothing = 0.5"), Contains("noise differs from cell to cell"));
  CHECK_THAT(lab_mistake(two_inks(kalman + "control.smoothing = 0\n")), Contains("knows one ink"));
  CHECK_THAT(lab_mistake("control.droplet_factors = \"on\""),
             Contains("control.droplet_factors") && Contains("height_estimate = \"kalman\""));
  CHECK_THAT(
      lab_mistake(kalman + "control.smoothing = 0\ncontrol.droplet_factors = \"on\"\ncontrol.adapt_model = "
                           "\"on\"\nestimator.droplets = \"on\""),
      Contains("one of them only"));
}

TEST_CASE("scheme auto learns the height of droplets itself, and knows no places inside cells") {
  CHECK_THAT(
      lab_mistake("control.scheme = \"auto\"\ncontrol.adapt_model = \"on\"\nestimator.droplets = \"on\""),
      Contains("control.scheme") && Contains("control.adapt_model"));
  CHECK_THAT(lab_mistake("control.scheme = \"auto\"\nactuation.offsets = \"x\""),
             Contains("control.scheme") && Contains("knows places"));
}

TEST_CASE("Geometry: a mesh goes with the shape mesh alone") {
  CHECK_THAT(lab_mistake("geometry.shape = \"mesh\""), Contains("needs a file"));
  CHECK_THAT(lab_mistake("geometry.mesh = \"a.stl\""), Contains("only geometry.shape \"mesh\""));
}

TEST_CASE("With two nozzles the stage's reach, the gap and the rate hold for nozzle B too") {
  CHECK(lab_mistake(two_inks("")) == "no error");
  CHECK_THAT(lab_mistake(two_inks("jet_b.offset_x_mm = 100.0")),
             Contains("run-up and the offset of nozzle B"));
  CHECK_THAT(lab_mistake(two_inks("jet_b.offset_x_mm = -145.0\nstage.x_max_mm = 150.0")),
             Contains("offset of nozzle B"));
  CHECK_THAT(
      lab_mistake(two_inks("process.nozzle_gap_mm = 0.5\njet_b.offset_z_mm = -0.75\nstage.z_min_mm = 0.0")),
      Contains("jet_b.offset_z_mm") && Contains("the gap of nozzle B"));
  CHECK_THAT(lab_mistake(two_inks("jet_b.max_rate_hz = 400")), Contains("jet_b.max_rate_hz"));
  CHECK(lab_mistake("jet_b.max_rate_hz = 400\njet_b.offset_x_mm = 100.0") == "no error");  // it takes no part
}

TEST_CASE("Parking lies within the stage, along both axes") {
  CHECK_THAT(lab_mistake("process.park_y_mm = 900.0"), Contains("process.park_y_mm") && Contains("parking"));
  CHECK_THAT(lab_mistake("process.park_x_mm = 900.0"), Contains("process.park_x_mm") && Contains("parking"));
}

TEST_CASE("A rule's place is the line of the first of its keys that a file sets") {
  CHECK_THAT(lab_mistake("\n\nmodel.h1_mm = 0.0001"), Contains("x.toml:3") && Contains("model.h2_mm"));
  CHECK_THAT(lab_mistake("\nmodel.h2_mm = 0.005\nmodel.h1_mm = 0.003"), Contains("x.toml:2"));
}

TEST_CASE("An ice lab needs its machine, and either sliced paths or a mesh with its settings") {
  CHECK(lab_mistake(ice_lab("")) == "no error");
  CHECK_THAT(lab_mistake("lab.kind = \"ice\"\ncontrol.scheme = \"smf\""), Contains("ice.mesh"));
  CHECK_THAT(lab_mistake("lab.kind = \"ice\"\ncontrol.scheme = \"smf\"\nice.mesh = \"a.stl\""),
             Contains("ice.slice"));
  CHECK_THAT(lab_mistake("lab.kind = \"ice\"\ncontrol.scheme = \"smf\"\nice.paths = \"a.paths\""),
             Contains("ice.machine"));
  CHECK_THAT(lab_mistake(ice_lab("ice.mesh = \"a.stl\"")),
             Contains("ice.paths") && Contains("sliced already"));
}

TEST_CASE("Each lab knows its own control schemes, and names them") {
  CHECK_THAT(lab_mistake(ice_lab("") + "control.mpc.seed = 1\n[control]\nscheme = \"mpc\""),
             Contains("control.scheme") || Contains("x.toml"));
  CHECK_THAT(lab_mistake("lab.kind = \"ice\"\ncontrol.scheme = \"mpc\""),
             Contains("control.scheme") && Contains("smf_foresee"));
  CHECK_THAT(lab_mistake("control.scheme = \"smf_foresee\""),
             Contains("control.scheme") && Contains("threshold"));
}

TEST_CASE("The nozzle's gap is above its clearance") {
  CHECK_THAT(lab_mistake(ice_lab("ice.nozzle_gap_mm = 0.5\nice.clearance_mm = 0.5")),
             Contains("ice.nozzle_gap_mm = 0.5 mm: must be above ice.clearance_mm"));
  CHECK(lab_mistake(ice_lab("ice.nozzle_gap_mm = 0.6\nice.clearance_mm = 0.5")) == "no error");
}

TEST_CASE("The columns of a valve's flow curve are equally long and ascend") {
  for (const std::string valve : {"valve_a", "valve_b"}) {
    const auto with = [&](const char* hz, const char* flow) {
      return lab_mistake(ice_lab("[" + valve + "]\ntable_hz = " + hz + "\ntable_mm3_s = " + flow));
    };
    CHECK(with("[10, 20, 30]", "[1, 2, 3]") == "no error");
    CHECK_THAT(with("[10, 20]", "[1, 2, 3]"), Contains(valve + ".table_hz") && Contains("as many"));
    CHECK_THAT(with("[10, 30, 20]", "[1, 2, 3]"), Contains("must ascend"));
    CHECK_THAT(with("[10, 20, 30]", "[1, 1, 3]"), Contains("must ascend"));
  }
}

TEST_CASE("The simulated table has four feet, nine screws, and five numbers a block") {
  CHECK(lab_mistake(ice_lab("plant.ice.foot_mm = [0, 0, 0, 1]")) == "no error");
  CHECK_THAT(lab_mistake(ice_lab("plant.ice.foot_mm = [0, 0, 0]")), Contains("needs four heights"));
  CHECK_THAT(lab_mistake(ice_lab("plant.ice.screw_mm = [0, 0, 0, 0]")), Contains("needs nine heights"));
  CHECK_THAT(lab_mistake(ice_lab("plant.ice.jig_mm = [0, 0, 1, 1]")), Contains("five numbers"));
  CHECK_THAT(lab_mistake(ice_lab("plant.ice.field_width_mm = 30")), Contains("must be 0 together"));
}

TEST_CASE("The tip's temperature lies between its alarms") {
  CHECK_THAT(lab_mistake(ice_lab("heater.tip_degC = 4.0")),
             Contains("heater.tip_degC") && Contains("heater.low_degC"));
  CHECK_THAT(lab_mistake(ice_lab("heater.high_degC = 19.0")), Contains("heater.high_degC = 19.0"));
}

TEST_CASE("The limit of an ice scheme's action is narrower than an ink-jet's") {
  CHECK_THAT(lab_mistake(ice_lab("") + "[valve_a]\nguard_us = 100\n[control.smf]\nki = 0.1"),
             !Contains("lab.kind = "));
  const std::string wide =
      "lab.kind = \"ice\"\ncontrol.scheme = \"smf\"\nice.paths = \"p\"\nice.machine = \"m\"\n"
      "control.smf.output_limit = ";
  CHECK_THAT(lab_mistake(wide + "50.0"), Contains("control.smf.output_limit") && Contains("ice"));
}
