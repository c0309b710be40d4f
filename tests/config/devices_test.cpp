// The ports of a lab's instruments.
#include "config/devices.h"

#include <catch2/catch.hpp>

#include "config/error.h"
#include "print/inputs/check_print.h"

using namespace firn;
using Catch::Contains;

namespace {

const std::string kReal =
    "[devices]\nstage.port = \"tcp:10.0.0.2\"\nlaser_profiler.port = \"tcp:10.0.0.3\"\n"
    "jet.port = \"serial:/dev/ttyUSB0\"\n";

Experiment read(const std::string& text) { return parse_experiment(text, "lab.toml"); }

}  // namespace

TEST_CASE("A device's port takes the speed and the TCP port of its kind where the address names none") {
  CHECK(parse_port_address("tcp:10.0.0.2", *port_defaults("stage")).tcp_port == 8000);
  CHECK(parse_port_address("tcp:10.0.0.2", *port_defaults("robot")).tcp_port == 4096);
  CHECK(parse_port_address("tcp:[::1]", *port_defaults("laser_profiler")).tcp_port == 24691);
  const PortAddress jet = parse_port_address("serial:/dev/ttyUSB0", *port_defaults("jet"));
  CHECK(jet.baud == 9600);
  CHECK(jet.open_wait_ms == 500);
  CHECK(parse_port_address("serial:/dev/ttyUSB0?baud=38400", *port_defaults("lamp")).baud == 38400);
  CHECK_FALSE(port_defaults("scheduler"));
}

TEST_CASE("Without [devices] every instrument is in the simulated world") {
  const Experiment e = read("");
  CHECK(real_ports(e).empty());
  CHECK(simulated_ports(e) == std::vector<std::string>{"stage", "jet", "laser_profiler", "lamp"});
  CHECK(ports_text(e) == "SIMULATED: stage, jet, laser_profiler, lamp");
}

TEST_CASE("Real and simulated instruments are told apart, with the defaults of their kinds") {
  const Experiment e = read(kReal);
  const auto real = real_ports(e);
  REQUIRE(real.size() == 3);
  CHECK(to_text(real.at("stage")) == "tcp:10.0.0.2:8000");
  CHECK(to_text(real.at("laser_profiler")) == "tcp:10.0.0.3:24691");
  CHECK(to_text(real.at("jet")) == "serial:/dev/ttyUSB0?baud=9600&frame=8N1&open_wait_ms=500");
  CHECK(simulated_ports(e) == std::vector<std::string>{"lamp"});
  CHECK_THAT(ports_text(e),
             Contains("REAL: stage (tcp:10.0.0.2:8000), jet (serial:") && Contains("; SIMULATED: lamp"));
}

TEST_CASE("What no instrument can be reached by is refused by its key") {
  const std::pair<std::string, std::string> wrong[] = {
      {"[devices.stage]\nport = \"usb\"\n", "devices.stage.port"},
      {"[devices.stage]\nport = \"tcp:a:99999\"\n", "port '99999'"},
      {"[devices.robot]\nport = \"tcp:a\"\n", "devices.robot.port"},
      {"[devices.scheduler]\nport = \"tcp:a\"\n", "devices.scheduler"},
      {kReal + "[run]\ntime_scale = 2\n", "run.time_scale"},
      {"[devices.stage]\nport = \"tcp:a\"\n", "no trigger line couples them"},
      {"[devices.jet]\nport = \"serial:/dev/ttyUSB0\"\n", "jet is real and laser_profiler simulated"},
  };
  for (const auto& [text, why] : wrong) {
    CAPTURE(text);
    CHECK_THROWS_WITH(read(text), Contains(why));
  }
}

TEST_CASE("A lamp alone may be real, and no real instrument is reached in one process") {
  const Experiment e = read("[devices.lamp]\nport = \"serial:/dev/ttyUSB1?baud=19200\"\n");
  CHECK(real_ports(e).size() == 1);
  CHECK_NOTHROW(check_print(e, ""));
  CHECK_THROWS_WITH(check_print(e, "in-process"), Contains("devices.lamp.port") && Contains("in-process"));
}
