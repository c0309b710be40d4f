#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "tests/plant/ice_bench.h"

using namespace firn;
using namespace firn::plant;
namespace host_fvp = drivers::fvp;
namespace host_fvb = drivers::fvb;

namespace {

/// The twins that are written from FVB/1, or those that run the firmware.
IceWorldConfig with_valves(IceWorldConfig config, bool firmware) {
  for (IceValveParams& v : config.valve) v.firmware = firmware;
  return config;
}

}  // namespace

TEST_CASE("The robot's twin wants power, calibration and a verified path at whose first point it stands") {
  const IceWorldConfig c = small();
  IceBench b(c);
  CHECK(b.robot("HELLO FIRN 1") == "ACK OK C40 1 TICK=0.016");
  CHECK(b.status().state == host_fvp::State::kIdle);
  CHECK(b.robot("CAL").starts_with("NAK 24"));
  CHECK(b.robot("MOVEZ 100000 20").starts_with("NAK 24"));
  b.robot("POWER 1");
  CHECK_FALSE(b.status().power);
  b.run(3'100'000);
  CHECK(b.status().power);
  CHECK(b.status().state1 == 8);
  CHECK(b.robot("MOVEZ 100000 20").starts_with("NAK 23"));
  b.robot("CAL");
  CHECK(b.status().state1 == 5);
  b.run(8'100'000);
  CHECK(b.status().state1 == 7);
  const auto run = line_of(c);
  CHECK(b.robot("PATH RUN 7 0").starts_with("NAK 20"));
  b.load(7, run.points);
  CHECK(b.status().state == host_fvp::State::kReady);
  CHECK(b.status().held[0] == 7);
  CHECK(b.robot("PATH RUN 7 0").starts_with("NAK 20"));  // it stands elsewhere
  CHECK(b.robot("MOVEZ 211000 20").starts_with("NAK 22"));
  b.move_to(run.points.front());
  CHECK(b.move_reply == "ACK");
  CHECK(b.robot("SPEED 50") == "ACK 50");
  CHECK(b.robot("PATH RUN 7 0").starts_with("NAK 30"));
  b.robot("SPEED 100");
  CHECK(b.robot("PATH RUN 7 0") == "ACK");
  CHECK(b.status().running == 7);
  b.wait_for_rest();
  const host_fvp::Status done = b.status();
  CHECK(done.last == 7);
  CHECK(done.last_done);
  CHECK(std::abs(done.last_ms - std::int32_t(std::lround((run.points.size() - 1) * 16.0))) <= 1);
  CHECK(b.heard[std::string(kRobotPort)].size() > 0);
}

TEST_CASE(
    "A repeated number gets the reply again without a second motion, an old one is refused, a damaged line "
    "is dropped") {
  IceBench b(small());
  b.home();
  drivers::LineWriter line;
  line.text("@100 MOVEZ 150000 20");
  const std::string move(line.finish(1));
  const std::string first = b.ask(kRobotPort, move);
  CHECK(b.ask(kRobotPort, move) == first);
  std::string damaged = move;
  damaged[6] ^= 1;
  CHECK(b.ask(kRobotPort, damaged, 300'000).find("MOVE_DONE") == std::string::npos);
  drivers::LineWriter old;
  old.text("@99 STAT");
  CHECK(b.ask(kRobotPort, old.finish(1)).find("NAK 11") != std::string::npos);
  b.seq = 100;
  b.wait_for_rest();
  int motions = 0;
  for (const DeviceRecord& d : b.record.history.devices) motions += d.event == DeviceEvent::kRobotMotion;
  CHECK(motions == 1);
}

TEST_CASE(
    "A path printed through the instruments lies where and as much as the list said, and is summed up") {
  IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  c.disturbance.debris_per_h = 0.0;
  IceBench b(c);
  const auto run = line_of(c, 5.0);
  prepare(b, run);
  CHECK(b.robot("PATH RUN 7 1") == "ACK");
  b.wait_for_rest();
  b.run(200'000);
  const host_fvb::Status s = b.valve_status(kValveAPort);
  CHECK(s.state == host_fvb::State::kDone);
  CHECK(s.next == run.ticks.size());
  const IceTruth t = b.truth();
  CHECK(t.pulses[0] == std::int64_t(run.ticks.size()));
  CHECK(t.pulses[1] == 0);
  CHECK(t.ledger.landed[0] == Approx(0.25 * double(run.ticks.size())).epsilon(0.05));
  REQUIRE(b.record.history.firings.size() == 1);
  const FiringRecord& f = b.record.history.firings[0];
  CHECK(f.path == 7);
  CHECK(f.fired == run.ticks.size());
  CHECK(f.end == FiringEnd::kThrough);
  CHECK(f.last_us == t.last_pulse_us[0]);
  CHECK(f.volume_mm3 == Approx(t.ledger.landed[0]));
  const HeightMap map = b.world.ice()->thickness_over({30, 3, 1.0, 2.0, -14.5, 3.0}, 0);
  double row = 0.0, beside = 0.0;
  for (int i = 3; i < 27; ++i) {
    row += map.at(i, 1);
    beside += map.at(i, 0) + map.at(i, 2);
  }
  CHECK(row > 4.0 * beside);
  CHECK(b.world.truth().exposures == 1);
  CHECK(b.world.truth().droplets_fired == std::int64_t(run.ticks.size()));
  CHECK(b.record.ok);
}

TEST_CASE("A valve refuses what would harm it and ignores triggers unless armed") {
  const IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  IceBench b(c);
  b.hello(kValveAPort);
  CHECK(b.arm(kValveAPort) == int(host_fvb::Refusal::kWrongState));
  CHECK(b.load_list(kValveAPort, 1, {10, 9}) == int(host_fvb::Refusal::kOrder));
  CHECK(b.load_list(kValveAPort, 1, {10, 10}) == int(host_fvb::Refusal::kOrder));
  CHECK(b.load_list(kValveAPort, 1, {10, 12, 40}) == 0);
  CHECK(b.valve_status(kValveAPort).state == host_fvb::State::kLoaded);
  b.home();
  b.robot("SIG 1");
  b.run(1'000'000);
  CHECK(b.truth().pulses[0] == 0);  // loaded, not armed
  b.robot("SIG 0");
  CHECK(b.arm(kValveAPort) == 0);
  CHECK(b.valve_status(kValveAPort).state == host_fvb::State::kArmed);
  b.robot("SIG 2");  // the other valve's line
  b.run(500'000);
  CHECK(b.truth().pulses[0] == 0);
  b.robot("SIG 3");
  b.run(500'000);
  CHECK(b.truth().pulses[0] == 3);
  CHECK(b.valve_status(kValveAPort).next == 3);
  CHECK(b.arm(kValveAPort) == int(host_fvb::Refusal::kWrongState));  // used up
}

TEST_CASE("STOP brakes the arm, drops the signals and closes the valves by their enable line") {
  const IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  IceBench b(c);
  const auto run = line_of(c);
  prepare(b, run);
  b.robot("PATH RUN 7 1");
  b.run(300'000);
  CHECK(b.robot("STOP") == "ACK");
  const std::int64_t stop_us = b.now_us;
  b.run(2'000'000);
  CHECK(b.truth().last_pulse_us[0] <= stop_us);
  CHECK(b.truth().last_pulse_us[0] > stop_us - 200'000);
  CHECK(b.valve_status(kValveAPort).state == host_fvb::State::kDone);
  CHECK(b.valve_status(kValveAPort).next == b.truth().pulses[0]);
  CHECK(b.status().state == host_fvp::State::kHold);
  CHECK((b.status().last == 7 && !b.status().last_done));
  CHECK(b.robot("PATH RUN 7 1").starts_with("NAK 20"));
  CHECK(b.robot("CLEAR") == "ACK");
  CHECK(b.status().state == host_fvp::State::kReady);
  REQUIRE(b.record.history.firings.size() == 1);
  CHECK(b.record.history.firings[0].end == FiringEnd::kDisabled);
}

TEST_CASE("A valve that hears nothing for two seconds of the host's time while it fires closes") {
  const bool firmware = GENERATE(false, true);
  for (const double scale : {1.0, 2.0}) {
    const IceWorldConfig c = with_valves(small(), firmware);
    IceBench b(c, scale);
    prepare(b, line_of(c, 0.0, 3.24, 5.0));  // six seconds
    b.robot("SIG 1");
    const std::int64_t from_us = b.now_us;
    b.run(7'000'000);
    REQUIRE(b.record.history.firings.size() == 1);
    CHECK(b.record.history.firings[0].end == FiringEnd::kWatchdog);
    CHECK(b.truth().last_pulse_us[0] <= from_us + std::int64_t(scale * 2e6));
    CHECK(b.truth().last_pulse_us[0] > from_us + std::int64_t(scale * 1.9e6));
    CHECK(b.valve_status(kValveAPort).state == host_fvb::State::kFault);
  }
}

TEST_CASE("A robot whose socket closes brakes whatever moves and closes the valves at once") {
  const IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  IceBench b(c);
  prepare(b, line_of(c));
  b.robot("PATH RUN 7 1");
  b.run(300'000);
  const std::int64_t gone_us = b.now_us;
  b.world.disconnect(kRobotPort, gone_us);
  b.run(2'000'000);
  CHECK(b.truth().last_pulse_us[0] <= gone_us);
  const auto braked =
      std::find_if(b.record.history.devices.begin(), b.record.history.devices.end(),
                   [](const DeviceRecord& d) { return d.event == DeviceEvent::kRobotWatchdog; });
  REQUIRE(braked != b.record.history.devices.end());
  CHECK(braked->t_us == gone_us);
}

TEST_CASE("A robot that hears nothing for a second while a path runs ends it and closes the valves") {
  IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  IceBench b(c);
  const auto run = line_of(c, 0.0, 3.24, 5.0);  // six seconds
  prepare(b, run);
  b.robot("PATH RUN 7 1");
  const std::int64_t from_us = b.now_us;
  b.run(5'000'000);
  bool watchdog = false;
  for (const DeviceRecord& d : b.record.history.devices)
    if (d.event == DeviceEvent::kRobotWatchdog) {
      watchdog = true;
      CHECK(d.t_us - from_us <= 1'000'000);
      CHECK(d.t_us - from_us > 990'000);
    }
  CHECK(watchdog);
  CHECK(b.status().state == host_fvp::State::kFault);
  CHECK(b.status().error == 40);
  REQUIRE(b.record.history.firings.size() == 1);
  CHECK(b.record.history.firings[0].end == FiringEnd::kDisabled);
  CHECK(b.truth().last_pulse_us[0] <= from_us + 1'000'000);
  CHECK(b.robot("CLEAR") == "ACK");
}

TEST_CASE(
    "The emergency stop cuts power and stays until it is released and cleared, and a motion error is a "
    "fault") {
  const IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  IceBench b(c);
  const auto run = line_of(c);
  prepare(b, run);
  b.robot("PATH RUN 7 1");
  b.run(200'000);
  b.world.inject({"robot", FaultKind::kTrip, 1, 0}, b.now_us);
  CHECK(b.status().state == host_fvp::State::kEstop);
  CHECK_FALSE(b.status().power);
  CHECK(b.status().state2 >= 1);
  CHECK(b.robot("CLEAR").starts_with("NAK"));
  b.world.inject({"robot", FaultKind::kTrip, 0, 0}, b.now_us);
  b.run(500'000);
  CHECK(b.robot("CLEAR") == "ACK");
  CHECK(b.status().state != host_fvp::State::kEstop);
  b.robot("POWER 1");
  b.run(3'100'000);
  b.move_to(run.points.front());
  b.robot("PATH RUN 7 0");
  b.run(100'000);
  b.world.inject({"robot", FaultKind::kTrip, 2, 0}, b.now_us);
  CHECK(b.status().state == host_fvp::State::kFault);
  CHECK(b.status().error < 0);
  REQUIRE_FALSE(b.events.empty());
  CHECK(b.events.back().starts_with("MOTION_ERR 7 7 -"));
}

TEST_CASE("Reboot loses paths and lists, closes the port and counts, and the valve says why it was reset") {
  const IceWorldConfig c = with_valves(small(), GENERATE(false, true));
  IceBench b(c);
  prepare(b, line_of(c));
  for (const char* port : {"robot", "valve_a"}) b.world.inject({port, FaultKind::kReboot, 1, 0}, b.now_us);
  b.run(3'000'000);
  CHECK(b.closed["robot"]);
  CHECK(b.closed["valve_a"]);
  b.connect();
  b.seq = 0;
  b.robot("HELLO FIRN 1");
  const host_fvp::Status s = b.status();
  CHECK(s.boot_count == 2);
  CHECK(s.held[0] == 0);
  CHECK_FALSE(s.power);
  std::vector<std::byte> bytes;
  host_fvb::encode(host_fvb::Type::kHello, 1, {}, bytes);
  b.vseq = 1;
  const auto hello = host_fvb::parse_hello(b.valve(kValveAPort, bytes).payload);
  REQUIRE(hello);
  CHECK(hello->boot_count == 2);
  CHECK(hello->reset_cause == 1);
  CHECK(b.valve_status(kValveAPort).state == host_fvb::State::kIdle);
}

TEST_CASE(
    "The laser stores while the robot's line is up, in its material's program, and dumps at the baud rate") {
  IceWorldConfig c = small();
  c.table.jigs.push_back({-5.0, -25.0, 5.0, 25.0, 2.0});
  IceBench b(c);
  const auto run = ice_paths::along(
      c.arm, c.arm.laser, {{-20.0, 0.0}, {20.0, 0.0}}, 1.0, 50.0, 1.5, [](double) { return 0.25; }, 0.0);
  b.home();
  b.load(3, run.points);
  b.move_to(run.points.front());
  CHECK(b.laser("M1").starts_with("M1,-01."));
  CHECK(b.laser("SW,CA,5") == "ER,CA,01\r");
  CHECK(b.laser("Q0") == "Q0\r");
  CHECK(b.laser("M1") == "ER,M1,01\r");
  CHECK(b.laser("SW,CA,5") == "SW,CA\r");
  CHECK(b.laser("SW,HB,1,1") == "SW,HB\r");
  CHECK(b.laser("SW,OC,1,0,1") == "SW,OC\r");
  CHECK(b.laser("SW,CI,1,65536,3") == "SW,CI\r");
  CHECK(b.laser("SW,CI,1,65536,77") == "ER,CI,22\r");
  const std::int64_t before_us = b.now_us;
  CHECK(b.laser("R0") == "R0\r");
  CHECK(b.now_us - before_us >= 600'000);
  CHECK(b.laser("AQ") == "AQ\r");
  CHECK(b.laser("AS") == "AS\r");
  b.run(1'000'000);
  CHECK(b.laser("AN") == "AN,1,0,0\r");  // the line is still down
  b.robot("PATH RUN 3 4");
  b.wait_for_rest();
  CHECK(b.laser("AP") == "AP\r");
  const double seconds = 0.016 * double(run.points.size() - 1);
  const std::string stored = b.laser("AN");
  const int values = std::atoi(stored.c_str() + 5);
  CHECK(values == Approx(seconds * 100.0).margin(3));
  const std::int64_t dump_us = b.now_us;
  const std::string dump = b.laser("AO,1");
  CHECK(double(b.now_us - dump_us) * 1e-6 == Approx(values * 9.0 * 10.0 / 115200.0).epsilon(0.02));
  std::vector<float> mm;
  REQUIRE(drivers::lkg::parse_dump(std::string_view(dump).substr(3, dump.size() - 4), mm));
  REQUIRE(int(mm.size()) == values);
  int high = 0;
  for (const float z : mm) high += z > 0.0f;
  CHECK(high == Approx(100.0 * 10.0 / 50.0).margin(3));  // 10 mm of jig at 50 mm/s
  b.world.inject({"laser_point", FaultKind::kTrip, 1, 0}, b.now_us);
  CHECK(b.laser("M1") == "M1,XXXXXXXX\r");
}

TEST_CASE("The heater box shows temperatures and relays, takes set points, and its faults are seen") {
  IceBench b(small());
  const auto read = [&] {
    drivers::LineWriter line;
    line.text("T?");
    const std::string reply = b.ask(kHeaterPort, line.finish(0));
    return drivers::thermostat::parse_reading(drivers::checked_text(reply, 0).value()).value();
  };
  CHECK(read().celsius[0] == Approx(20.0).margin(0.1));
  drivers::LineWriter set;
  drivers::thermostat::put(set, drivers::thermostat::SetPoint{2, 2500});
  const std::string sent(set.finish(0));
  CHECK(b.ask(kHeaterPort, sent) == sent);
  b.run(600'000'000);
  CHECK(read().celsius[1] == Approx(25.0).margin(1.2));
  b.world.inject({"heater", FaultKind::kTrip, 4, 0}, b.now_us);
  CHECK(std::isnan(read().celsius[0]));
  CHECK_FALSE(read().heating[0]);
  b.world.inject({"heater", FaultKind::kTrip, 0, 0}, b.now_us);
  b.world.inject({"heater", FaultKind::kTrip, 1, 0}, b.now_us);
  b.run(1'200'000'000);
  CHECK(read().celsius[0] < 18.0);
  CHECK(read().heating[0]);
  CHECK(b.ask(kHeaterPort, "nonsense\n").starts_with("E,1*"));
}

TEST_CASE(
    "A tank that runs empty, a blocked line and a dead coil give pulses without liquid until they are "
    "mended") {
  const bool firmware = GENERATE(false, true);
  for (const std::int64_t code : {1, 2, 3}) {
    const IceWorldConfig c = with_valves(small(), firmware);
    IceBench b(c);
    const auto run = line_of(c);
    b.world.inject({"valve_a", FaultKind::kTrip, code, 0}, b.now_us);
    prepare(b, run);
    b.robot("PATH RUN 7 1");
    b.wait_for_rest();
    b.run(100'000);
    CHECK(b.truth().pulses[0] == std::int64_t(run.ticks.size()));
    CHECK(b.truth().ledger.landed[0] < 0.2 * 0.25 * double(run.ticks.size()));
    b.world.inject({"valve_a", FaultKind::kTrip, 0, 0}, b.now_us);
    b.run(100'000);
    const double before = b.truth().ledger.landed[0];
    REQUIRE(b.load_list(kValveAPort, 8, run.ticks) == 0);
    b.move_to(run.points.front());
    REQUIRE(b.arm(kValveAPort) == 0);
    b.robot("PATH RUN 7 1");
    b.wait_for_rest();
    b.run(100'000);
    CHECK(b.truth().ledger.landed[0] - before > 0.9 * 0.25 * double(run.ticks.size()));
  }
}

TEST_CASE(
    "Frozen thermocouples, stuck laser values, refused power, echoes and stray replies are what they say") {
  IceBench b(small());
  b.world.inject({"robot", FaultKind::kTrip, 3, 0}, b.now_us);
  b.robot("HELLO FIRN 1");
  b.robot("POWER 1");
  b.run(5'000'000);
  CHECK_FALSE(b.status().power);
  b.world.inject({"robot", FaultKind::kTrip, 0, 0}, b.now_us);
  b.home();
  CHECK(b.status().calibrated);

  b.world.inject({"laser_point", FaultKind::kTrip, 2, 0}, b.now_us);
  const std::string stuck = b.laser("M1");
  b.robot("MOVEZ 21000 20");
  b.wait_for_rest();
  CHECK(b.laser("M1") == stuck);
  b.world.inject({"laser_point", FaultKind::kTrip, 0, 0}, b.now_us);
  CHECK(b.laser("M1") != stuck);

  b.world.inject({"laser_point", FaultKind::kEcho, 1, 0}, b.now_us);
  const std::string echoed = b.laser("PR");
  CHECK(echoed.starts_with("PR\r"));
  b.run(1'000'000);
  const std::string before = b.laser("PR");
  b.world.inject({"laser_point", FaultKind::kStray, 1, 0}, b.now_us);
  CHECK(b.laser("AN") == before);  // the true answer follows
  b.run(1'000'000);
  CHECK(b.heard["laser_point"] == before + "AN,0,0,0\r");

  const auto read = [&] {
    drivers::LineWriter line;
    line.text("T?");
    const std::string reply = b.ask(kHeaterPort, line.finish(0));
    return drivers::thermostat::parse_reading(drivers::checked_text(reply, 0).value()).value();
  };
  const double shown = read().celsius[1];
  b.world.inject({"heater", FaultKind::kTrip, 11, 0}, b.now_us);
  b.run(100'000'000);
  CHECK(read().celsius[1] == Approx(shown).margin(1.0));
  const double frozen = read().celsius[1];
  b.run(100'000'000);
  CHECK(read().celsius[1] == frozen);
}
