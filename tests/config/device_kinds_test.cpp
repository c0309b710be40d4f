// Who speaks with an instrument: the keys devices.NODE.kind, and ports that suit them.
#include "config/device_kinds.h"

#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/reader.h"

using namespace firn;
using Catch::Contains;

namespace {

Experiment kinds_in(const std::string& text) { return parse_experiment(text, "lab.toml"); }

std::string mistake_of(const std::string& text) {
  try {
    kinds_in(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "taken";
}

}  // namespace

TEST_CASE("a class in Python is named with file, class and arguments, for a port through Firn or its own",
          "[kinds]") {
  const Experiment e = kinds_in(
      "[devices.lamp]\nport = \"tcp:10.0.0.7:5025\"\nkind = \"python:own/psu.py:Lamp(volts=12.0)\"\n");
  CHECK(is_python_driver(e, "lamp"));
  CHECK_FALSE(has_own_port(e, "lamp"));
  const drivers::ScriptOptions s = script_options(e, "lamp", 0.25);
  CHECK(s.file == "psu.py");
  CHECK(s.class_name == "Lamp");
  CHECK(s.arguments == "volts=12.0");
  CHECK_FALSE(s.own_port);
  CHECK(
      has_own_port(kinds_in("[devices.lamp]\nport = \"python:\"\nkind = \"python:psu.py:Lamp\"\n"), "lamp"));
}

TEST_CASE("a kind comes back from the dump, and is not in one that names none", "[kinds]") {
  const std::string text = "[devices.stage]\nkind = \"grbl\"\n";
  CHECK(has_grbl_stage(parse_experiment(dump(kinds_in(text)), "dump.toml")));
  CHECK(dump(kinds_in("")).find("kind = \"ensemble\"") == std::string::npos);
}

TEST_CASE("a kind that is none is refused with the ones that are", "[kinds]") {
  CHECK_THAT(mistake_of("[devices.stage]\nkind = \"marlin\"\n"),
             Contains("devices.stage.kind") && Contains("ensemble, grbl, python:FILE.py:CLASS"));
  CHECK_THAT(mistake_of("[devices.stage]\nkind = \"grlb\"\n"), Contains("grbl"));
  CHECK_THAT(
      mistake_of("[lab]\nkind = \"ice\"\n[ice]\nmesh = \"-\"\n[devices.robot]\nkind = \"python:a.py:B\"\n"),
      Contains("devices.robot.kind"));
}

TEST_CASE("a driver in Python is refused in the simulated world, by port and kind", "[kinds]") {
  CHECK_THAT(mistake_of("[devices.lamp]\nkind = \"python:psu.py:Lamp\"\n"),
             Contains("devices.lamp.port") && Contains("a fake of it"));
}

TEST_CASE("the port of a class that opens its instrument itself needs a class", "[kinds]") {
  CHECK_THAT(mistake_of("[devices.lamp]\nport = \"python:\"\n"),
             Contains("devices.lamp.port") && Contains("devices.lamp.kind names none"));
}

TEST_CASE("a jet's maker is named in one place", "[kinds]") {
  CHECK(mistake_of("[devices.jet]\nkind = \"jetdrive\"\n") == "taken");
  CHECK_THAT(mistake_of("[devices.jet]\nkind = \"microdrop\"\n"),
             Contains("jet.kind, which is \"jetdrive\""));
}

TEST_CASE("each class of instruments of the ink-jet lab takes a class in Python at a port of its own",
          "[kinds]") {
  for (const char* node : {"stage", "jet", "laser_profiler", "lamp"}) {
    const std::string name(node);
    std::string text = "[devices]\n";
    // A stage, a jet and a profiler are real together, or none: trigger lines couple them.
    for (const char* other : {"stage", "jet", "laser_profiler", "lamp"})
      text += std::string(other) + ".port = \"python:\"\n" + other + ".kind = \"python:own.py:Own\"\n";
    const Experiment e = kinds_in(text);
    INFO(name);
    CHECK(is_python_driver(e, name));
    CHECK(has_own_port(e, name));
    CHECK(script_options(e, name, 0.0).node == name);
  }
}

TEST_CASE("arguments of a class may hold quotes, commas and equal signs", "[kinds]") {
  const Experiment e = kinds_in(
      "[devices.lamp]\nport = \"python:\"\nkind = \"python:psu.py:Lamp(resource='TCPIP::10.0.0.7::INSTR', "
      "a=1)\"\n");
  CHECK(script_options(e, "lamp", 0.0).arguments == "resource='TCPIP::10.0.0.7::INSTR', a=1");
  CHECK(parse_experiment(dump(e), "dump.toml").devices.kind == e.devices.kind);
}

TEST_CASE("what a point laser in the profiler's place cannot do is refused by key", "[kinds]") {
  const std::string kind = "[devices.laser_profiler]\nkind = \"lkg\"\n";
  CHECK(mistake_of(kind) == "taken");
  CHECK(has_point_scan(kinds_in(kind)));
  CHECK_THAT(mistake_of(kind + "[laser_profiler]\ndx_mm = 0.01\n"),
             Contains("laser_profiler.dx_mm") && Contains("middle of each column"));
  CHECK_THAT(mistake_of(kind + "[laser_profiler]\nmirror_x = \"on\"\n"), Contains("a point has no sides"));
  CHECK_THAT(mistake_of(kind + "[laser_profiler]\nread = \"memory\"\n"), Contains("keeps no profiles"));
  CHECK_THAT(mistake_of(kind + "[laser_profiler]\nprogram = 8\n"), Contains("programs 0 to 7"));
  CHECK_THAT(mistake_of(kind + "[laser_profiler]\noffset_x_mm = 300.0\n"),
             Contains("laser_profiler.offset_x_mm") && Contains("the spot over each column"));
  CHECK_THAT(mistake_of(kind + "[process]\nscan_speed_mm_s = 150.0\n[stage]\nmax_speed_mm_s = 200.0\n"
                               "acceleration_mm_s2 = 100000.0\n"),
             Contains("process.scan_speed_mm_s") && Contains("115200 baud carry 500"));
}
