// Calibrations of the ice lab whose instruments stand behind serial lines and TCP ports, by the clock: each
// must find what it finds in simulated time.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "studies/calibrate/lab_calibrations.h"
#include "tests/cli/run_firn.h"
#include "tests/live/port_bridge.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

/// An ice lab with the block on its table, whose instruments stand behind lines.
class LinedLab {
 public:
  /// The simulated surface lies about (x, y), part frame. @param keys of the lab, besides
  LinedLab(std::vector<std::string> keys, double x_mm, double y_mm, double width_mm, double depth_mm)
      : keys_(with_tip_warm(std::move(keys))),
        world_(lab_calibrations::with_jig(lab_calibrations::with_field(load_lab_experiment(kIce, keys_), x_mm,
                                                                       y_mm, width_mm, depth_mm))) {}

  Said calibrate(const std::string& what, bool real, const std::vector<std::string>& more) const {
    std::vector<std::string> words{
        "calibrate", what, kIce,
        "--json",    "-o", (fresh_folder("calibrate-lines-" + what) / "lab.toml").string()};
    words.insert(words.end(), more.begin(), more.end());
    for (const std::string& key : keys_) words.insert(words.end(), {"--set", key});
    const std::pair<const char*, std::string> ports[] = {{"robot", robot_.address()},
                                                         {"valve_a", valve_a_.address(115200)},
                                                         {"valve_b", valve_b_.address(115200)},
                                                         {"laser_point", laser_.address(115200)},
                                                         {"heater", heater_.address(9600)}};
    for (const auto& [node, address] : ports)
      if (real)
        words.insert(words.end(), {"--set", "devices." + std::string(node) + ".port=\"" + address + "\""});
    return firn_says(words);
  }

 private:
  static std::vector<std::string> with_tip_warm(std::vector<std::string> keys) {
    keys.push_back("heater.low_degC=-40");  // at once
    return keys;
  }

  std::vector<std::string> keys_;
  SimulatedInstruments world_;
  PortBridge robot_{PortBridge::Kind::kTcp, world_.address("robot").place};
  PortBridge valve_a_{PortBridge::Kind::kSerial, world_.address("valve_a").place};
  PortBridge valve_b_{PortBridge::Kind::kSerial, world_.address("valve_b").place};
  PortBridge laser_{PortBridge::Kind::kSerial, world_.address("laser_point").place};
  PortBridge heater_{PortBridge::Kind::kSerial, world_.address("heater").place};
};

struct Found {
  Json real, simulated;
};

Found both(const LinedLab& lab, const std::string& what, const std::vector<std::string>& more) {
  const Said real = lab.calibrate(what, true, more), simulated = lab.calibrate(what, false, more);
  INFO(real.out << real.err << simulated.err);
  REQUIRE(real.code == 0);
  REQUIRE(simulated.code == 0);
  CHECK_THAT(real.err, Contains("REAL: robot (tcp:127.0.0.1:") && Contains("laser_point (serial:/dev/pts/"));
  return {Json::parse(real.out), Json::parse(simulated.out)};
}

void check_same(const Found& f, const std::vector<std::string>& names) {
  CHECK(f.real["data"] == f.simulated["data"]);
  REQUIRE(f.real["keys"].size() == names.size());
  for (std::size_t n = 0; n < names.size(); ++n) {
    const Json &real = f.real["keys"][n], &simulated = f.simulated["keys"][n];
    INFO(real.dump() << " " << simulated.dump());
    CHECK(real["key"] == names[n]);
    const auto half = [](const Json& key) { return key["half_95"].get<double>(); };
    CHECK(std::abs(real["value"].get<double>() - simulated["value"].get<double>()) <
          half(real) + half(simulated));
  }
}

}  // namespace

TEST_CASE("the laser's offset is found on real ports as in the simulated lab") {
  const LinedLab lab({}, -60.0, -60.0, 10.0, 10.0);
  check_same(both(lab, "laser-offset", {"--repeats", "1"}),
             {"laser_point.offset_x_mm", "laser_point.offset_y_mm"});
}

TEST_CASE("the table is levelled on real ports as in the simulated lab") {
  // A small table, so that few points are read.
  const LinedLab lab({"calibration.level_x_mm=[0, 90, 180]", "calibration.level_y_mm=[-100, 100, 300]",
                      "calibration.table_width_mm=230", "calibration.table_depth_mm=430"},
                     -60.0, -60.0, 10.0, 10.0);
  const Found f = both(lab, "level-table", {});
  CHECK(f.real["level"] == f.simulated["level"]);
  check_same(f, {"ice.origin_z_mm"});
}

TEST_CASE("a valve's latency is found on real ports as in the simulated lab") {
  const LinedLab lab({}, 20.0, -20.0, 120.0, 40.0);
  check_same(both(lab, "valve-latency", {"--repeats", "1"}), {"valve_a.latency_s"});
}
