#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "plant/twins/motion.h"
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::plant;

TEST_CASE("The stage twin speaks the card's transcript ens_pso_row") {
  Bench b{WorldConfig{}};
  CHECK(b.stage("WAIT MODE NOWAIT") == "%\n");
  CHECK(b.stage("AXISFAULT(@0)") == "%0\n");
  CHECK(b.stage("ENABLE @0") == "%\n");
  CHECK(b.stage("PSOCONTROL @0 RESET") == "%\n");
  CHECK(b.stage("PSODISTANCE @0 ARRAY") == "%\n");
  CHECK(b.stage("LINEAR @0 999 F10") == "%\n");  // acknowledged, then the soft limit, bit 4
  CHECK(b.stage("AXISFAULT(@0)") == "%16\n");
  CHECK(b.stage("LINAER @0 1") == "!\n");
  CHECK(b.stage("ENABLE @0") == "#\n");  // FAULTACK before ENABLE after a fault
  CHECK(b.stage("FAULTACK @0") == "%\n");
  CHECK(b.stage("ENABLE @0") == "%\n");
  CHECK(b.stage("LINEAR @0 -999 F10") == "%\n");
  CHECK(b.stage("AXISFAULT(@0)") == "%32\n");  // bit 5
}

TEST_CASE("Position, speed and status follow the trapezoid in time") {
  Bench b{WorldConfig{}};
  start_stage(b, 1000.0);
  CHECK(b.stage("AXISSTATUS(@0)") == "%5\n");  // enabled, in position
  b.stage("LINEAR @0 20 F50");
  const std::int64_t t0 = b.now_us - 300;  // the answer took the latency
  b.now_us = t0;
  b.run(300'000);
  b.heard.clear();
  CHECK(b.ask(kStagePort, "PFBKPROG(@0)\n") == "%13.750000\n");  // 1.25 + 50 (0.3 - 0.05)
  b.now_us = t0;
  b.run(300'600);
  CHECK(b.stage("VFBK(@0)") == "%50.000000\n");
  CHECK(b.stage("PLANESTATUS(0)") == "%1\n");
  CHECK(b.stage("AXISSTATUS(@0)") == "%9\n");  // enabled, moving
  b.run(200'000);
  CHECK(b.stage("PLANESTATUS(0)") == "%0\n");
  CHECK(b.stage("AXISSTATUS(@0)") == "%5\n");
  CHECK(b.stage("PFBKPROG(@0)") == "%20.000000\n");
}

TEST_CASE("Array pulses come at the exact crossing times of the trapezoid, by closed form, either way") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    WorldConfig c;
    c.stage.latency_us = 0;
    Bench b(c);
    RandomStream random(seed, Purpose::kTest);
    const double accel = random.uniform(200, 5000), speed = random.uniform(5, 150);
    const double side = seed % 2 == 0 ? 1.0 : -1.0;
    start_stage(b, std::round(accel));
    b.stage("PSOCONTROL @0 RESET");
    b.stage("PSOOUTPUT @0 PULSE");
    std::vector<double> at_mm;
    std::int64_t sum = 0;
    const int pulses = 2 + int(random.below(30));
    for (int n = 0; n < pulses; ++n) {
      const std::int64_t increment = 500 + random.below(4000);
      b.stage("IGLOBAL(" + std::to_string(50 + n) + ")=" + std::to_string(increment));
      sum += increment;
      at_mm.push_back(double(sum) / 1e4);
    }
    b.stage("PSOARRAY @0,50," + std::to_string(pulses));
    b.stage("PSODISTANCE @0 ARRAY");
    b.stage("PSOCONTROL @0 ARM");
    const double length = std::floor(at_mm.back()) + 3.0, v = std::round(speed), a = std::round(accel);
    b.stage("LINEAR @0 " + std::to_string(side * length) + " F" + std::to_string(v));
    const std::int64_t t0 = b.now_us;
    b.run(60'000'000);
    const auto& shots = b.record.history.shots;
    REQUIRE(shots.size() == at_mm.size());
    // Independent closed form: ramp up to p = min(v, sqrt(L a)), cruise, ramp down.
    const double peak = std::min(v, std::sqrt(length * a)), ramp = peak * peak / (2 * a);
    const double whole = 2 * peak / a + (length - 2 * ramp) / peak;
    for (std::size_t n = 0; n < at_mm.size(); ++n) {
      const double s = at_mm[n];
      const double t = s < ramp            ? std::sqrt(2 * s / a)
                       : s < length - ramp ? peak / a + (s - ramp) / peak
                                           : whole - std::sqrt(2 * (length - s) / a);
      CHECK(std::abs(double(shots[n].t_us - t0) - t * 1e6) <= 1.0);
      CHECK(shots[n].x_mm == Approx(side * s).margin(1e-9));
      CHECK(shots[n].outcome == ShotOutcome::kGatedSource);  // nobody armed the jet
    }
    CHECK(b.stage("PSOCOUNT(@0)") == "%" + std::to_string(pulses) + "\n");
  }
}

TEST_CASE("Fixed-distance pulses trigger the profiler every row, first one distance after ARM") {
  Bench b{WorldConfig{}};
  start_stage(b);
  b.stage("PSOCONTROL @1 RESET");
  b.stage("PSOOUTPUT @1 PULSE");
  b.stage("PSODISTANCE @1 FIXED 0.25 UNITS");
  b.stage("PSOCONTROL @1 ARM");
  go(b, "LINEAR @1 2.6 F15");
  const auto& scans = b.record.history.scans;
  REQUIRE(scans.size() == 10);
  for (std::size_t n = 0; n < scans.size(); ++n) {
    CHECK(scans[n].y_mm == Approx(0.25 * double(n + 1)).margin(1e-9));
    CHECK(scans[n].encoder_count == int(2500 * (n + 1)));
    CHECK(scans[n].trigger_count == n + 1);
  }
  CHECK(b.stage("PSOCOUNT(@1)") == "%10\n");
}

TEST_CASE("A window masks pulses outside it and they do not count") {
  Bench b{WorldConfig{}};
  start_stage(b);
  for (const char* line :
       {"PSOCONTROL @0 RESET", "PSOWINDOW @0 1 INPUT 3", "PSOWINDOW @0 1 RANGE 1.05,2.05 UNITS",
        "PSOOUTPUT @0 PULSE WINDOW MASK", "PSODISTANCE @0 FIXED 0.1 UNITS", "PSOCONTROL @0 ARM"})
    CHECK(b.stage(line) == "%\n");
  go(b, "LINEAR @0 3 F20");
  CHECK(b.stage("PSOCOUNT(@0)") == "%10\n");
}

TEST_CASE("ABORT decelerates, keeps the pulses armed, and later moves go on from there") {
  Bench b{WorldConfig{}};
  start_stage(b);
  b.stage("PSOCONTROL @0 RESET");
  b.stage("PSODISTANCE @0 FIXED 0.1 UNITS");
  b.stage("PSOOUTPUT @0 PULSE");
  b.stage("PSOCONTROL @0 ARM");
  b.stage("LINEAR @0 50 F100");
  b.run(200'000);
  CHECK(b.stage("ABORT @0") == "%\n");
  b.run(200'000);
  CHECK(b.stage("PLANESTATUS(0)") == "%0\n");
  const double x = std::stod(b.stage("PFBKPROG(@0)").substr(1));
  CHECK((x > 19.0 && x < 23.0));
  CHECK(std::stoi(b.stage("PSOCOUNT(@0)").substr(1)) == int(x / 0.1));
  go(b, "LINEAR @0 10 F100");
  CHECK(b.stage("PFBKPROG(@0)") == "%10.000000\n");
}

TEST_CASE("In the power-on wait mode a move keeps its answer and the next command until it is over") {
  Bench b{WorldConfig{}};
  b.stage("ENABLE @0");
  const std::int64_t t0 = b.now_us;
  b.send(kStagePort, "LINEAR @0 10 F10\nPLANESTATUS(0)\n");
  b.run(500'000);
  CHECK(b.heard["stage"] == "%\n");  // of ENABLE
  b.run(5'000'000);
  CHECK(b.heard["stage"] == "%\n%\n%0\n");
  CHECK(b.log.back().t_us > t0 + 1'000'000);
}

TEST_CASE("The controller's own watchdog stops motion and pulses when the socket closes") {
  Bench b{WorldConfig{}};
  start_stage(b);
  b.stage("PSOCONTROL @0 RESET");
  b.stage("PSOOUTPUT @0 PULSE");
  b.stage("PSODISTANCE @0 FIXED 0.1 UNITS");
  b.stage("PSOCONTROL @0 ARM");
  b.stage("LINEAR @0 100 F50");
  b.run(100'000);
  b.world.disconnect(kStagePort, b.now_us);
  const std::int64_t lost_us = b.now_us;
  b.run(5'000'000);
  for (const ShotRecord& shot : b.record.history.shots) CHECK(shot.t_us <= lost_us);
  b.world.connect(kStagePort, b.now_us);
  CHECK(b.stage("PLANESTATUS(0)") == "%0\n");
  CHECK(std::stod(b.stage("PFBKPROG(@0)").substr(1)) < 10.0);
}

TEST_CASE("An idle socket is closed by the controller when it is told to") {
  WorldConfig c;
  c.stage.idle_close_us = 2'000'000;
  Bench b(c);
  b.stage("ENABLE @0");
  b.run(1'900'000);
  CHECK_FALSE(b.closed["stage"]);
  b.run(200'000);
  CHECK(b.closed["stage"]);
}

TEST_CASE("Homing sets the homed bit, an emergency stop latches until it is released and acknowledged") {
  Bench b{WorldConfig{}};
  start_stage(b);
  go(b, "LINEAR @0 5 F50");
  b.stage("HOME @0");
  CHECK(b.stage("AXISSTATUS(@0)") == "%" + std::to_string(1 | 8 | 1 << 14) + "\n");
  b.run(2'000'000);
  CHECK(b.stage("AXISSTATUS(@0)") == "%7\n");
  b.world.inject({"stage", FaultKind::kTrip, 1, 0}, b.now_us);
  CHECK(b.stage("AXISFAULT(@0)") == "%2048\n");
  b.stage("FAULTACK @0");
  CHECK(b.stage("ENABLE @0") == "#\n");
  b.world.inject({"stage", FaultKind::kTrip, 0, 0}, b.now_us);
  b.stage("FAULTACK @0");
  CHECK(b.stage("ENABLE @0") == "%\n");
}
