// The robot's V+ text on the simulated controller, against the twin that is written from FVP/1.
#include <catch2/catch.hpp>

#include <filesystem>

#include "tests/plant/robot_pair.h"
#include "tests/plant/vplus_text.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::plant;

namespace {

IceWorldConfig vplus_world(int statements_per_tick = 160) {
  IceWorldConfig c = small();
  c.disturbance.debris_per_h = 0.0;
  c.robot = shipped_program(statements_per_tick);
  return c;
}

void replace(IceRobotProgram& program, std::string_view from, std::string_view to) {
  for (IceProgramText& t : program.texts)
    if (const std::size_t at = t.text.find(from); at != std::string::npos) {
      t.text.replace(at, from.size(), to);
      return;
    }
  FAIL("the V+ text has no \"" << from << "\"");
}

}  // namespace

TEST_CASE("the V+ text and the twin of FVP/1 answer and move alike, whatever is asked and disturbed") {
  // All of it: build/bench/vplus_bench difference
  for (const int budget : {80, 160, 1600}) {
    IceWorldConfig config = small();
    config.arm.slip_probability = 0.2;
    RobotPair pair(config, shipped_program(budget), 40 + std::uint64_t(budget));
    pair.run(1500);
    INFO(budget << " statements in a tick");
    CHECK(pair.differences() == std::vector<std::string>{});
    const PairCounts& c = pair.counts();
    CHECK(c.resent > 40);
    CHECK(c.refused > 40);
    CHECK(c.reconnects > 2);
    CHECK(c.samples > 200);
    CHECK(c.stops + c.silences + c.trips > 2);
  }
}

TEST_CASE("the comparison of the robot's twins finds an error that is planted in the V+ text") {
  const std::pair<const char*, const char*> errors[] = {
      {"off = 50", "off = 5000000"},
      {"(v > high)", "(v > high+1)"},
      {"fv.pt[s,n,2]*1E-4", "(fv.pt[s,n,2]+3)*1E-4"},
      {"DURATION 0.016 ALWAYS", "DURATION 0.032 ALWAYS"},
      {"fv.held = FALSE\n\t\tfv.fault = FALSE", "fv.fault = FALSE"},
      {"seq == fv.seq", "seq == -1"},
      {"(TIMER(1) > 1)", "(TIMER(1) > 9)"},
      {"$fv.rest = $fv.rest+$piece", "$fv.rest = $piece"},
      {"FCMND (fv.lun, 600) $INTB(fv.client)", "got = 0"},
      {"\tREACTE fv.react", "\t;"},
  };
  for (const auto& [from, to] : errors) {
    INFO(from << " became " << to);
    IceRobotProgram program = shipped_program(320);
    replace(program, from, to);
    std::size_t found = 0;
    for (std::uint64_t seed = 1; found == 0 && seed <= 4; ++seed) {
      RobotPair pair(small(), program, seed);
      pair.run(3000);
      found += pair.differences().size();
    }
    CHECK(found > 0);
  }
}

TEST_CASE("a path printed through the V+ text lies where the list said") {
  IceWorldConfig plain = vplus_world();
  plain.robot = {};
  std::array<IceTruth, 2> truth;
  std::array<double, 2> row{};
  for (int n = 0; n < 2; ++n) {
    IceBench b(n == 0 ? plain : vplus_world());
    b.run(3'000'000);
    const auto run = line_of(plain, 5.0);
    prepare(b, run);
    CHECK(b.robot("PATH RUN 7 1") == "ACK");
    b.wait_for_rest();
    b.run(200'000);
    CHECK(b.valve_status(kValveAPort).next == run.ticks.size());
    truth[std::size_t(n)] = b.truth();
    const HeightMap map = b.world.ice()->thickness_over({30, 3, 1.0, 2.0, -14.5, 3.0}, 0);
    for (int i = 3; i < 27; ++i) row[std::size_t(n)] += map.at(i, 1);
    if (n == 1) CHECK(b.world.ice()->vplus_robot()->late_segments() == 0);
  }
  CHECK(truth[0].pulses == truth[1].pulses);
  CHECK(truth[1].ledger.landed[0] == Approx(truth[0].ledger.landed[0]).epsilon(0.01));
  CHECK(row[1] == Approx(row[0]).epsilon(0.02));
}

TEST_CASE("whenever a STOP comes to the V+ program, its signals are low a tick after the answer") {
  for (int at_ms = 0; at_ms < 200; at_ms += 7) {
    const IceWorldConfig c = vplus_world(100);
    IceBench b(c);
    b.run(3'000'000);
    prepare(b, line_of(c, 0.0, 3.24, 20.0));
    REQUIRE(b.robot("PATH RUN 7 7") == "ACK");
    b.run(at_ms * 1000);
    REQUIRE(b.robot("STOP") == "ACK");
    b.run(16'000);
    int mask = 0;
    for (const DeviceRecord& d : b.record.history.devices)
      if (d.event == DeviceEvent::kSignals) mask = int(d.value);
    INFO(at_ms << " ms after the path was asked for");
    CHECK(mask == 0);
    b.run(1'000'000);
    CHECK(b.status().state == drivers::fvp::State::kHold);
    CHECK(b.status().last == 7);
    CHECK_FALSE(b.status().last_done);
    CHECK(b.robot("CLEAR") == "ACK");
  }
}

TEST_CASE(
    "the emergency stop is a state of the V+ program with the arm still or moving, until it is released and "
    "cleared") {
  for (const bool moves : {false, true}) {
    const IceWorldConfig c = vplus_world();
    IceBench b(c);
    b.run(3'000'000);
    b.home();
    if (moves) CHECK(b.robot("MOVEJ 500000 400000 100000 0 20") == "ACK");
    b.run(100'000);
    b.world.inject({"robot", FaultKind::kTrip, 1, 0}, b.now_us);
    b.run(500'000);
    CHECK(b.status().state == drivers::fvp::State::kEstop);
    CHECK(b.robot("CLEAR").starts_with("NAK 20"));
    b.world.inject({"robot", FaultKind::kTrip, 0, 0}, b.now_us);
    CHECK(b.status().state == drivers::fvp::State::kEstop);
    CHECK(b.robot("CLEAR") == "ACK");
    b.robot("POWER 1");
    b.run(3'200'000);
    CHECK(b.robot("MOVEZ 150000 20") == "ACK");  // the task that moves the arm has outlived it
    b.wait_for_rest();
    CHECK(b.world.ice()->nature().arm().reference()[2] == Approx(150.0).margin(1e-3));
  }
}

TEST_CASE("a world that is saved while the V+ text runs a path goes on as one that was not") {
  const IceWorldConfig c = vplus_world();
  const test::TempFolder folder;
  const std::filesystem::path file = folder.path() / "world.state";
  const auto ends_at = [&](bool saved) {
    IceBench b(c);
    b.run(3'000'000);
    prepare(b, line_of(c, 5.0));
    b.robot("PATH RUN 7 1");
    b.run(250'000);
    if (saved) {
      b.world.save(file);
      b.world = World::restore(file, IceBench::config_of(c, 1.0), &b.record, true);
    }
    b.run(2'000'000);
    return std::pair(b.truth().ledger.landed[0], b.world.ice()->nature().arm().encoders());
  };
  CHECK(ends_at(true) == ends_at(false));
}
