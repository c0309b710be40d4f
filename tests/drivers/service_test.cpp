// A person's orders to one instrument (firn device), against the twins of both labs.
#include <catch2/catch.hpp>

#include <cmath>

#include "tests/drivers/bench.h"
#include "tests/drivers/ice_rig.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using Catch::Contains;
using firn::drivers::test::IceRig;
using firn::drivers::test::PortRig;
using firn::drivers::test::WorldRig;

namespace {

void give(PortRig& rig, const std::string& port, std::string_view verb, const std::vector<double>& values) {
  rig.act(port, [&](std::int64_t t, Effects& fx) { rig.driver(port).serve(verb, values, t, fx); });
}

Result serve(PortRig& rig, const std::string& port, std::string_view verb,
             const std::vector<double>& values = {}, double within_s = 60.0) {
  const std::size_t before = rig.all<Result>(port).size();
  give(rig, port, verb, values);
  INFO(port << " " << verb);
  REQUIRE(rig.run([&] { return rig.all<Result>(port).size() > before; }, within_s));
  return rig.all<Result>(port).back();
}

void check_refused(PortRig& rig, const std::string& port, std::string_view verb,
                   const std::vector<double>& values, const char* why) {
  const std::string sent = rig.written[port];
  const Result r = serve(rig, port, verb, values);
  CHECK(r.outcome == Outcome::kRefused);
  CHECK_THAT(r.text, Contains(why));
  CHECK(rig.written[port] == sent);
}

std::string jet_frame(std::string_view hex) { return test::unhex(hex); }

}  // namespace

TEST_CASE("a jet fires the number of droplets that a person asks for, and none afterwards",
          "[service][corrected:jet-verbs]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  const Result r = serve(rig, "jet", "fire", {5});
  CHECK(r.outcome == Outcome::kDone);
  CHECK(rig.jet.safe());
  CHECK_THAT(rig.written["jet"], Contains(jet_frame("53 04 03 00 05 0C 53 02 09 0B")));
  CHECK(rig.written["jet"].ends_with(jet_frame("53 04 03 00 01 08")));  // as a print has it
  CHECK(rig.record.history.shots.size() == 5);
  rig.run_for(3.0);
  CHECK(rig.record.history.shots.size() == 5);
}

TEST_CASE("continuous jetting ends with its time, and a stop ends it at once and first of all",
          "[service][corrected:jet-verbs]") {
  const std::string on = jet_frame("53 03 04 01 08"), off = jet_frame("53 03 04 00 07");
  const std::string internal = jet_frame("53 03 08 00 0B");
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  const std::int64_t began_us = rig.now_us;
  CHECK(serve(rig, "jet", "continuous", {2.0}).outcome == Outcome::kDone);
  CHECK(double(rig.now_us - began_us) * 1e-6 == Approx(2.0).margin(0.1));
  CHECK_THAT(rig.written["jet"], Contains(on));
  CHECK(rig.written["jet"].ends_with(off));

  give(rig, "jet", "continuous", {100.0});
  rig.run_for(1.0);
  CHECK(rig.jet.state() == DeviceState::kActive);
  const std::size_t before = rig.written["jet"].size();
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
  CHECK(rig.written["jet"].substr(before) == off + internal);
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 1.0));
  CHECK(rig.results("jet").back().outcome == Outcome::kFailed);
  CHECK_THAT(rig.results("jet").back().text, Contains("safe stop"));
  CHECK(serve(rig, "jet", "fire", {1}).outcome == Outcome::kDone);
}

TEST_CASE("a link that is lost while a jet fires for a person leaves its droplets in doubt", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  give(rig, "jet", "continuous", {100.0});
  rig.run_for(1.0);
  rig.world.inject({"jet", plant::FaultKind::kClose, 1, 0}, rig.now_us);
  REQUIRE(rig.run([&] { return !rig.results("jet").empty(); }, 10.0));
  CHECK(rig.results("jet").back().outcome == Outcome::kUnknown);
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 30.0));
  CHECK(rig.written["jet"].rfind(jet_frame("53 03 04 00 07")) >
        rig.written["jet"].rfind(jet_frame("53 03 04 01 08")));
}

TEST_CASE("orders beyond their limits are refused by name, and no byte is sent", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  REQUIRE(serve(rig, "stage", "where").outcome == Outcome::kDone);
  check_refused(rig, "jet", "fire", {3000}, "(0, 2000]");
  check_refused(rig, "jet", "fire", {1.5}, "1.5");
  check_refused(rig, "jet", "continuous", {181}, "(0, 180] s");
  check_refused(rig, "jet", "continuous", {-1}, "(0, 180] s");
  check_refused(rig, "jet", "strobe", {0, 10}, "divider");
  check_refused(rig, "jet", "strobe", {1, 70000}, "65535");
  check_refused(rig, "jet", "waveform", {101, -20, 20, 40}, "100 V");
  check_refused(rig, "jet", "waveform", {20.5, -20, 20, 40}, "whole volts");
  check_refused(rig, "stage", "jog", {6, 0, 0, 5, 0}, "beyond 5 mm");
  check_refused(rig, "stage", "jog", {1, 0, 0, 11, 0}, "--far");
  check_refused(rig, "stage", "pulse", {0, 1}, "1 to 1000");
  check_refused(rig, "stage", "pulse", {100, 1}, "(0, 50] mm");
  check_refused(rig, "lamp", "shutter", {100}, "(0, 20] s");
  check_refused(rig, "lamp", "iris", {0}, "1 to 100");
  check_refused(rig, "lamp", "sing", {}, "no order 'sing'");
}

TEST_CASE("a stage is jogged from where it is, tells its place, and keeps its limits", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  CHECK(serve(rig, "stage", "jog", {3, -2, 1, 10, 0}).outcome == Outcome::kDone);
  CHECK(serve(rig, "stage", "jog", {1, 0, 0, 10, 0}).outcome == Outcome::kDone);
  CHECK(serve(rig, "stage", "where").text == "x 4.0000, y -2.0000, z 1.0000");
  const Result far = serve(rig, "stage", "jog", {1000, 0, 0, 50, 1});
  CHECK(far.outcome == Outcome::kRefused);
  CHECK_THAT(far.text, Contains("is outside"));
  const Result params = serve(rig, "stage", "params");
  CHECK_THAT(params.text, Contains("x counts per unit 10000.0000") && Contains("z high limit 50.0000"));
  CHECK_THAT(serve(rig, "stage", "serial").text, Contains("version 4.07.001"));
}

TEST_CASE("a stage gives a person's pulses to the jet, one a pitch", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(7, t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 10.0));
  const Result r = serve(rig, "stage", "pulse", {7, 0.5});
  CHECK(r.outcome == Outcome::kDone);
  CHECK(r.counted == 7);
  CHECK(rig.fired() == 7);
}

TEST_CASE("a lamp is lit, put out, asked for its hours and its serial number", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  CHECK(serve(rig, "lamp", "hours").text == "lamp hours 340");
  CHECK_THAT(serve(rig, "lamp", "serial").text, Contains("board 105 serial 20158"));
  CHECK(serve(rig, "lamp", "iris", {30}).outcome == Outcome::kDone);
  CHECK(serve(rig, "lamp", "shutter", {0.5}).outcome == Outcome::kDone);
  CHECK(rig.world.exposures() == 1);
  CHECK(rig.sent("lamp", "SIL") == 1);  // the shutter leaves the iris as it is
  CHECK(serve(rig, "lamp", "off").outcome == Outcome::kDone);
  CHECK(serve(rig, "lamp", "on").outcome == Outcome::kDone);
  CHECK(rig.lamp.safe());
}

TEST_CASE("a profiler gives its newest profile once there is one, and its errors", "[service]") {
  WorldRig rig(WorldRig::small_world(8, 8));
  rig.start();
  const Result none = serve(rig, "laser_profiler", "read");
  CHECK(none.outcome == Outcome::kNone);
  CHECK_THAT(none.text, Contains("a trigger is wanted"));
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.scan(2.0, 1.0, 1.0, 0.5, 3, 5.0, t, fx); });
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 30.0));
  rig.run_for(0.2);
  const Result read = serve(rig, "laser_profiler", "read");
  CHECK(read.outcome == Outcome::kDone);
  const auto rows = rig.all<ProfileRow>("laser_profiler");
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].z_mm.size() == 800);
  CHECK(serve(rig, "laser_profiler", "errors").text == "no error");
}

TEST_CASE("a reset sets an instrument up anew", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  const std::size_t before = rig.written["jet"].size();
  CHECK(serve(rig, "jet", "reset").outcome == Outcome::kDone);
  CHECK_FALSE(rig.jet.safe());
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 30.0));
  CHECK_THAT(rig.written["jet"].substr(before), Contains("X2000") && Contains(jet_frame("53 02 01 03")));
}

TEST_CASE("an order to an instrument that is not safe, or busy with another, is refused", "[service]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  give(rig, "jet", "continuous", {5.0});
  give(rig, "jet", "fire", {1});
  REQUIRE(rig.results("jet").size() == 1);
  CHECK_THAT(rig.results("jet")[0].text, Contains("busy with another"));
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 5.0));
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(1, t, fx); });
  REQUIRE(rig.run([&] { return rig.jet.state() == DeviceState::kArmed; }, 5.0));
  CHECK(serve(rig, "jet", "fire", {1}).outcome == Outcome::kRefused);
}

TEST_CASE("a robot tells its joints, turns one of them, and how many lines a second it takes", "[service]") {
  IceRig rig;
  rig.start();
  const Result where = serve(rig, "robot", "where");
  CHECK_THAT(where.text, Contains("J1 ") && Contains(" mm, J4"));
  const double before = rig.robot.joints()->at(0);
  CHECK(serve(rig, "robot", "jog", {1, 2.0, 0}).outcome == Outcome::kDone);
  REQUIRE(serve(rig, "robot", "where").outcome == Outcome::kDone);
  CHECK((rig.robot.joints()->at(0) - before) * 180.0 / 3.14159265358979 == Approx(2.0).margin(0.001));
  CHECK_THAT(serve(rig, "robot", "lines", {100}).text, Contains("100 lines in"));
  check_refused(rig, "robot", "jog", {1, 6.0, 0}, "5 deg");
  check_refused(rig, "robot", "jog", {5, 1.0, 0}, "joint 1 to 4");
}

TEST_CASE("a valve spits the number of pulses that a person asks for", "[service]") {
  IceRig rig;
  rig.start();
  const Result spit = serve(rig, "valve_a", "spit", {20});
  INFO(spit.text);
  CHECK(spit.outcome == Outcome::kDone);
  CHECK(rig.valve_a.safe());
  REQUIRE(rig.record.history.firings.size() == 1);
  CHECK(rig.record.history.firings[0].fired == 20);
  check_refused(rig, "valve_a", "spit", {51}, "1 to 50");
  // A stop closes the valve in the middle of it.
  give(rig, "valve_b", "spit", {50});
  rig.run_for(0.3);
  rig.act("valve_b", [&](std::int64_t t, Effects& fx) { rig.valve_b.safe_stop(t, fx); });
  REQUIRE(rig.run([&] { return rig.valve_b.safe(); }, 2.0));
  CHECK(rig.all<Result>("valve_b").back().outcome == Outcome::kFailed);
  REQUIRE(rig.record.history.firings.size() == 2);
  CHECK(rig.record.history.firings[1].fired < 25);
}

TEST_CASE("an instrument whose line breaks tells every refused order of the loss until it is there again",
          "[service]") {
  const auto check = [](auto& rig, const std::string& port) {
    CAPTURE(port);
    rig.start();
    rig.world.inject({port, plant::FaultKind::kClose, 1, 0}, rig.now_us);
    REQUIRE(rig.run([&] { return !rig.driver(port).safe(); }, 5.0));
    int asked = 0;
    for (; !rig.driver(port).safe() && asked < 1000; ++asked) {
      const Result r = serve(rig, port, "no such verb");
      if (!rig.driver(port).safe()) CHECK_THAT(r.text, Contains("(port closed)"));
      rig.run_for(0.05);
    }
    CHECK(asked > 1);
    CHECK(rig.driver(port).safe());
    CHECK_THAT(serve(rig, port, "no such verb").text, !Contains("closed"));
  };
  for (const char* port : {"stage", "jet", "laser_profiler", "lamp"}) {
    WorldRig rig(WorldRig::small_world(6, 4));
    check(rig, port);
  }
  for (const char* port : {"robot", "valve_a", "laser_point", "heater"}) {
    IceRig rig;
    check(rig, port);
  }
}
