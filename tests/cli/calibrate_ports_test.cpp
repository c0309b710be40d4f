// A calibration of the ice lab whose instruments stand behind serial lines and TCP ports, by the clock.
#include <catch2/catch.hpp>
#include <cmath>

#include "files/json.h"
#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "runtime/run_clock.h"
#include "studies/calibrate/lab_calibrations.h"
#include "tests/cli/run_firn.h"
#include "tests/live/port_bridge.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

TEST_CASE("the laser's latency is measured on real ports as in the simulated lab", "[calibrate]") {
  const std::vector<std::string> keys{"heater.low_degC=-40"};  // the tip is warm enough at once
  using namespace lab_calibrations;
  SimulatedInstruments world(with_jig(with_field(load_lab_experiment(kIce, keys), -60.0, -60.0, 10.0, 10.0)));
  using Kind = PortBridge::Kind;
  const PortBridge robot(Kind::kTcp, world.address("robot").place);
  const PortBridge valve_a(Kind::kSerial, world.address("valve_a").place);
  const PortBridge valve_b(Kind::kSerial, world.address("valve_b").place);
  const PortBridge laser(Kind::kSerial, world.address("laser_point").place);
  const PortBridge heater(Kind::kSerial, world.address("heater").place);
  const std::string out = (fresh_folder("calibrate-ports") / "lab.toml").string();
  const auto said = [&](bool real, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"calibrate", "laser-latency", kIce, "--repeats", "4", "--json", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    for (const std::string& key : keys) words.insert(words.end(), {"--set", key});
    const std::pair<const char*, std::string> ports[] = {{"robot", robot.address()},
                                                         {"valve_a", valve_a.address(115200)},
                                                         {"valve_b", valve_b.address(115200)},
                                                         {"laser_point", laser.address(115200)},
                                                         {"heater", heater.address(9600)}};
    for (const auto& [node, address] : ports)
      if (real)
        words.insert(words.end(), {"--set", "devices." + std::string(node) + ".port=\"" + address + "\""});
    return firn_says(words);
  };
  const std::int64_t began_us = monotonic_us();
  const Said real = said(true);
  const double took_s = double(monotonic_us() - began_us) * 1e-6;
  INFO(real.out << real.err);
  REQUIRE(real.code == 0);
  CHECK_THAT(real.err, Contains("REAL: robot (tcp:127.0.0.1:") && Contains("laser_point (serial:/dev/pts/"));
  const Json measured = Json::parse(real.out);
  CHECK(measured["lab_s"].get<double>() == Approx(took_s).margin(10.0));  // by the clock
  const Json expected = Json::parse(said(false).out);
  CHECK(measured["data"] == expected["data"]);
  const auto value = [](const Json& j, const char* what) { return j["keys"][0][what].get<double>(); };
  CHECK(measured["keys"][0]["key"] == "laser_point.latency_s");
  CHECK(std::abs(value(measured, "value") - value(expected, "value")) <
        value(measured, "half_95") + value(expected, "half_95"));

  const Said table = firn_says({"calibrate", "level-table", kIce, "--rounds", "2", "-o", out, "--set",
                                "devices.heater.port=\"" + heater.address(9600) + "\""});
  CHECK(table.code == 2);
  CHECK_THAT(table.err, Contains("--rounds"));
}
