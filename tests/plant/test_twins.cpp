#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/grid/random.h"
#include "plant/twins/lamp.h"
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::plant;

TEST_CASE("The lamp twin speaks the card's vectors") {
  Bench b{WorldConfig{}};
  CHECK(b.ask(kLampPort, "OPN40\r") == "Err67\r");  // CONN comes first
  CHECK(b.ask(kLampPort, "CONN18\r") == "READY0A\r");
  CHECK(b.ask(kLampPort, "OPN40\r") == "ReceivedBF\r");
  CHECK(b.ask(kLampPort, "OPN41\r") == "Err67\r");
  CHECK(b.ask(kLampPort, "CLS3A\r") == "ReceivedBF\r");
  CHECK(b.ask(kLampPort, "DCONE1\r") == "CLOSED42\r");
  CHECK(lamp_crc8("Received") == 0xBF);
  CHECK(lamp_crc8("Err") == 0x67);
}

TEST_CASE("Serial twins are paced at their baud rate both ways") {
  Bench b{WorldConfig{}};
  b.ask(kLampPort, "CONN18\r");  // 7 bytes in, 8 out, 10 bits each
  CHECK(b.now_us == Approx(15 * 10e6 / 19200).margin(2.0));
  const std::int64_t t = b.now_us;
  b.ask(kJetPort, "Q");
  CHECK(b.now_us - t == Approx(2 * 10e6 / 9600).margin(2.0));
}

TEST_CASE("The jet twin speaks the card's frames, and what is wrong is refused") {
  Bench b{WorldConfig{}};
  CHECK(b.ask(kJetPort, hex("53 02 02 04"), 100'000) == "");  // deaf before the handshake
  CHECK(b.ask(kJetPort, "Q") == ">");
  for (const char* c : {"X", "2", "0", "0", "0"}) CHECK(b.ask(kJetPort, c) == c);
  CHECK(b.ask(kJetPort, hex("53 03 08 01 0C")) == hex("06 08 00 08"));
  CHECK(b.ask(kJetPort, hex("53 04 12 03 E8 01")) == hex("06 12 00 12"));
  CHECK(b.ask(kJetPort, hex("53 03 08 01 0D")) == hex("15 08 01 09"));  // checksum
  CHECK(b.ask(kJetPort, hex("53 02 77 79")) == hex("15 77 02 79"));     // unknown
  CHECK(b.ask(kJetPort, hex("53 02 F0 F2")).size() == 5);
  CHECK(b.ask(kJetPort, hex("53 02 60 62")).size() == 29);
  const std::int64_t t = b.now_us;
  CHECK(b.ask(kJetPort, hex("53 02 01 03")) == hex("06 01 00 01"));  // RESET takes 3 s
  CHECK(b.now_us - t >= 3'000'000);
  CHECK(b.ask(kJetPort, hex("53 02 02 04")) == hex("06 02 00 02"));  // source internal, no waveform
}

TEST_CASE("Only an armed jet with a waveform fires, and every trigger is on record with its reason") {
  Bench b{WorldConfig{}};
  start_stage(b);
  b.stage("PSOCONTROL @0 RESET");
  b.stage("PSOOUTPUT @0 PULSE");
  b.stage("PSODISTANCE @0 FIXED 0.5 UNITS");
  const auto row = [&](const char* line) {
    b.record.history.shots.clear();
    b.stage("PSOCONTROL @0 ARM");
    go(b, line);
    std::vector<ShotOutcome> outcomes;
    for (const ShotRecord& s : b.record.history.shots) outcomes.push_back(s.outcome);
    return outcomes;
  };
  using Outcomes = std::vector<ShotOutcome>;
  CHECK(row("LINEAR @0 1.6 F50") == Outcomes(3, ShotOutcome::kGatedSource));
  b.ask(kJetPort, "Q");
  for (const char* c : {"X", "2", "0", "0", "0"}) b.ask(kJetPort, c);
  arm_jet(b);
  CHECK(row("LINEAR @0 0 F50") == Outcomes(3, ShotOutcome::kGatedNoWaveform));
  start_jet(b);
  arm_jet(b);
  CHECK(row("LINEAR @0 1.6 F50") == Outcomes(3, ShotOutcome::kFired));
  b.stage("PSODISTANCE @0 FIXED 0.01 UNITS");
  const auto fast = row("LINEAR @0 0 F100");  // 10 kHz at a 2 kHz jet
  CHECK(std::count(fast.begin(), fast.end(), ShotOutcome::kGatedTooFast) >
        std::count(fast.begin(), fast.end(), ShotOutcome::kFired));
  disarm_jet(b);
  CHECK(b.world.truth().triggers_gated > 6);
  const DeviceRecord& last = b.record.history.devices.back();
  CHECK(last.event == DeviceEvent::kJetDisarmed);
}

TEST_CASE("A waveform loaded while the jet is armed is a recorded abuse") {
  Bench b{WorldConfig{}};
  start_jet(b);
  const auto abuses = [&] {
    int n = 0;
    for (const DeviceRecord& d : b.record.history.devices) n += d.event == DeviceEvent::kJetAbused;
    return n;
  };
  CHECK(abuses() == 0);
  arm_jet(b);
  start_jet(b);
  CHECK(abuses() == 1);
}

TEST_CASE("The lamp cures by dose, times an exposure itself, and closes at its longest on-time") {
  WorldConfig c;
  c.lamp.max_on_us = 3'000'000;
  Bench b(c);
  const auto framed = [](const std::string& text) {
    char tail[8];
    std::snprintf(tail, sizeof tail, "%02X\r", lamp_crc8(text));
    return text + tail;
  };
  b.ask(kLampPort, "CONN18\r");
  b.ask(kLampPort, framed("SIL50"));
  b.ask(kLampPort, "OPN40\r");
  b.run(1'000'000);
  b.ask(kLampPort, "CLS3A\r");
  CHECK(b.world.exposures() == 1);
  CHECK(b.record.history.lamp.back().dose_s == Approx(0.5).epsilon(0.02));
  b.ask(kLampPort, framed("STM10"));
  CHECK(b.ask(kLampPort, framed("GTM")) == framed("10"));
  b.ask(kLampPort, framed("RUN"));
  b.run(2'000'000);
  CHECK(b.record.history.lamp.back().dose_s == Approx(0.5).epsilon(1e-9));
  CHECK(b.world.exposures() == 2);
  b.ask(kLampPort, "OPN40\r");
  b.world.disconnect(kLampPort, b.now_us);  // no lost-link timeout: only the longest on-time helps
  b.run(10'000'000);
  CHECK(b.record.history.lamp.back().event == LampEvent::kWatchdog);
  CHECK(b.world.exposures() == 3);
}

TEST_CASE("The profiler answers its newest profile: header, counts and 20-bit points") {
  WorldConfig c;
  c.sensor.noise_mm = c.sensor.dropout_floor = 0.0;
  Bench b(c);
  const std::string ask =
      hex("20000000 0100F000 00000000 14000000 42000000 00000000 00000000 01000000 01010000");
  const auto u32 = [](const std::string& s, std::size_t at) {
    std::uint32_t v = 0;
    for (int n = 3; n >= 0; --n) v = v << 8 | std::uint8_t(s[at + std::size_t(n)]);
    return v;
  };
  std::string none = b.ask(kProfilerPort, ask);
  REQUIRE(none.size() == 28 + 24);
  CHECK(none[17] == 0);
  CHECK(none[28 + 12] == 0);  // no profile yet
  const std::string program =
      b.ask(kProfilerPort, hex("14000000 0100F000 00000000 08000000 39000000 05000000"));
  CHECK(program == hex("18000000 010000F0 00000000 0C000000 39000000 00000000 05000000"));
  start_stage(b);
  b.stage("PSOCONTROL @1 RESET");
  b.stage("PSOOUTPUT @1 PULSE");
  b.stage("PSODISTANCE @1 FIXED 1 UNITS");
  b.stage("PSOCONTROL @1 ARM");
  go(b, "LINEAR @1 3.5 F50");
  const std::string r = b.ask(kProfilerPort, ask);
  REQUIRE(r.size() == 28 + 60 + 2000 + 4);
  CHECK(u32(r, 0) == r.size() - 4);
  CHECK(u32(r, 12) == r.size() - 16);
  CHECK(std::uint8_t(r[16]) == 0x42);
  CHECK(r[28 + 12] == 1);
  CHECK((u32(r, 52) & 0xffff) == 800);
  CHECK(u32(r, 52) >> 16 == 10);
  CHECK(u32(r, 60) == 2000);  // 20 um: 1.15 x 10.53 mm / 800, rounded up to 5 um
  CHECK(u32(r, 68) == 3);
  CHECK(u32(r, 72) == 30000);
  const double x0 = double(std::int32_t(u32(r, 56))) * 1e-5;
  CHECK(x0 == Approx(0.5 * 39 * 0.263256 - 399.5 * 0.02).margin(1e-5));
  for (std::size_t n = 88; n < r.size(); ++n) CHECK(r[n] == 0);  // level ground
}

TEST_CASE("The profiler packs 8 points in 20 bytes, signed, invalid ones as the lowest number") {
  WorldConfig c;
  c.profiler.points = 8;
  c.sensor.dropout_floor = 1.0;  // nothing is ever seen
  Bench b(c);
  start_stage(b);
  b.stage("PSOCONTROL @1 RESET");
  b.stage("PSOOUTPUT @1 PULSE");
  b.stage("PSODISTANCE @1 FIXED 1 UNITS");
  b.stage("PSOCONTROL @1 ARM");
  go(b, "LINEAR @1 1.5 F50");
  const std::string r = b.ask(
      kProfilerPort, hex("20000000 0100F000 00000000 14000000 42000000 00000000 00000000 01000000 01010000"));
  REQUIRE(r.size() == 28 + 60 + 20 + 4);
  CHECK(r.substr(88, 20) == hex("00 00 08 00 80 00 00 08 00 80 00 00 08 00 80 00 00 08 00 80"));
}

TEST_CASE("Faults: a dropped, late, split or flipped reply, silence, a closed port, a reboot") {
  Bench b{WorldConfig{}};
  b.world.inject({"stage", FaultKind::kDropReply, 1, 0}, b.now_us);
  CHECK(b.stage("ENABLE @0") == "");
  CHECK(b.stage("ENABLE @0") == "%\n");
  b.world.inject({"stage", FaultKind::kDelayReply, 1, 1'000'000}, b.now_us);
  std::int64_t t = b.now_us;
  CHECK(b.stage("ENABLE @0") == "%\n");
  CHECK(b.now_us - t == 1'000'300);
  b.world.inject({"lamp", FaultKind::kSplitReply, 1, 5000}, b.now_us);
  t = b.now_us;
  CHECK(b.ask(kLampPort, "CONN18\r") == "R");
  b.run(1'000'000);
  CHECK(b.heard["lamp"] == "READY0A\r");
  b.world.inject({"lamp", FaultKind::kFlipBit, 1, 0}, b.now_us);
  CHECK(b.ask(kLampPort, "OPN40\r") == "PeceivedBF\r");
  b.world.inject({"lamp", FaultKind::kHang, 1, 0}, b.now_us);
  CHECK(b.ask(kLampPort, "CLS3A\r") == "");
  b.world.inject({"lamp", FaultKind::kResume, 1, 0}, b.now_us);
  CHECK(b.ask(kLampPort, "CLS3A\r") == "ReceivedBF\r");
  b.world.inject({"laser_profiler", FaultKind::kClose, 1, 0}, b.now_us);
  b.run(1);
  CHECK(b.closed["laser_profiler"]);
  start_jet(b);
  arm_jet(b);
  b.world.inject({"jet", FaultKind::kReboot, 1, 0}, b.now_us);
  b.run(1);
  CHECK(b.closed["jet"]);
  b.world.connect(kJetPort, b.now_us);
  CHECK(b.ask(kJetPort, hex("53 02 02 04"), 100'000) == "");  // it wants its handshake again
  b.ask(kJetPort, "Q");
  for (const char* c : {"X", "2", "0", "0", "0"}) b.ask(kJetPort, c);
  const std::string dump = b.ask(kJetPort, hex("53 02 60 62"));
  CHECK(dump.substr(6, 4) == hex("00 00 00 02"));  // boot count
  CHECK(dump[10] == 0);                            // source internal again
  CHECK_THROWS_AS(b.world.inject({"laser", FaultKind::kClose, 1, 0}, b.now_us), std::invalid_argument);
}

TEST_CASE("A half-open connection carries nothing either way and does not end, and the next one is sound") {
  Bench b{WorldConfig{}};
  for (const auto& [port, question, answer] :
       {std::tuple{kStagePort, "ENABLE @0\n", "%\n"}, {kLampPort, "CONN18\r", "READY0A\r"}}) {
    CAPTURE(port);
    CHECK(b.ask(port, question) == answer);
    b.world.inject({std::string(port), FaultKind::kHalfOpen, 1, 0}, b.now_us);
    CHECK(b.ask(port, question) == "");
    b.run(100'000'000);
    CHECK(b.heard[std::string(port)].empty());
    CHECK_FALSE(b.closed[std::string(port)]);
    CHECK(b.ask(port, question) == "");
    b.world.connect(port, b.now_us);
    CHECK(b.ask(port, question) == answer);
  }
}

TEST_CASE("Random bytes into every twin never crash and never fire a disarmed jet") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Bench b{WorldConfig{}};
    RandomStream random(seed, Purpose::kTest);
    static const std::vector<std::string> kSeeds{"LINEAR @0 1 F10\n",   "PSODISTANCE @0 FIXED 1e300 UNITS\n",
                                                 "IGLOBAL(4095)=1\n",   "IGLOBAL(99999)=1\n",
                                                 "PSOARRAY @0,50,3\n",  "PSOCONTROL @0 ARM\n",
                                                 "HOME @0 @1\n",        "RAMP RATE -1\n",
                                                 "LINEAR @0 nan F10\n", "ABORT\n",
                                                 "PSOOUTPUT X PULSE\n", "ENABLE Z\n",
                                                 "LINEAR @2 inf F1\n",  "MOVEABS X 3 F1e-300\n",
                                                 "FAULTACK @0\n"};
    for (int n = 0; n < 400; ++n) {
      const std::string_view port =
          std::array{kStagePort, kJetPort, kProfilerPort, kLampPort}[random.below(4)];
      std::string bytes;
      if (port == kStagePort && random.below(2) == 0) {
        bytes = kSeeds[random.below(std::uint32_t(kSeeds.size()))];
        if (random.below(3) == 0) bytes[random.below(std::uint32_t(bytes.size()))] = char(random.bits());
      } else if (port == kProfilerPort && random.below(2) == 0) {
        bytes = hex("20000000 0100F000 00000000 14000000 42000000 00000000 00000000 01000000 01010000");
        bytes[random.below(36)] = char(random.bits());
      } else {
        const std::uint32_t length = random.below(80);
        for (std::uint32_t k = 0; k < length; ++k)
          bytes.push_back(char(random.below(4) == 0 ? 'S' : random.bits()));
      }
      b.send(port, bytes);
      b.run(random.below(50'000));
      if (random.below(40) == 0)
        b.world.inject({std::string(port), FaultKind(random.below(9)), std::int64_t(random.below(3)), 1000},
                       b.now_us);
      if (!b.world.next_event_us()) FAIL("an event in the past");
      b.world.connect(port, b.now_us);
    }
    b.run(1'000'000'000);
    CHECK(b.record.ok);
    CHECK(b.world.truth().droplets_fired == 0);
  }
}
