// The point laser's driver against a fake of the LK-G: every value once, none invented.
#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/laser_point/laser_point.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/fake_laser.h"
#include "tests/drivers/fake_rig.h"
#include "tests/drivers/lossy_line.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::FakeLaser;
using firn::drivers::test::next;

namespace {

const std::string kLaserTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";
using LaserRig = test::FakeRig<LaserPoint, FakeLaser>;

LaserPointOptions slow_readings() {
  LaserPointOptions o;
  o.sampling_us = 1000;
  o.averaging = 1;
  return o;
}

struct LaserLab {
  FakeLaser fake;
  LaserPoint laser;
  LaserRig rig;

  explicit LaserLab(LaserPointOptions config = slow_readings()) : laser(std::move(config)), rig(laser, fake) {
    rig.lines = false;
  }

  void start() {
    rig.open();
    REQUIRE(rig.run([&] { return laser.safe(); }, 20));
    rig.events.clear();
  }
  template <class F>
  Result command(F&& f, double limit_s = 120) {
    rig.act(f);
    REQUIRE(rig.run([&] { return !laser.busy(); }, limit_s));
    return rig.all<Result>().back();
  }
  Result arm(int material, int samples) {
    return command([&](std::int64_t t, Effects& fx) { laser.arm(material, samples, 0.01, t, fx); });
  }
  Result collect() {
    return command([&](std::int64_t t, Effects& fx) { laser.collect(t, fx); });
  }
};

std::vector<double> some_heights(std::size_t n, std::uint64_t seed) {
  std::vector<double> h;
  for (std::size_t k = 0; k < n; ++k) {
    const double mm = (double(next(seed) % 100'000) - 50'000) * 1e-4;
    h.push_back(next(seed) % 10 == 0 ? std::nan("") : next(seed) % 30 == 0 ? 400.0 : mm);
  }
  return h;
}

}  // namespace

TEST_CASE("the point laser's driver speaks as its card says, whatever the split of the replies",
          "[laser_point]") {
  for (const std::size_t split : {0, 1, 2, 5}) {
    LaserPoint laser{slow_readings()};
    test::play(
        laser, kLaserTranscripts + "lkg_storage.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) {
          if (c == "arm")
            laser.arm(0, 4, 0.01, t, fx);
          else if (c == "collect")
            laser.collect(t, fx);
          else if (c == "reading")
            laser.reading(t, fx);
          else
            FAIL("no command " << c);
        },
        split);
  }
}

TEST_CASE("what was stored comes back value by value, and what is no number is NaN", "[laser_point]") {
  LaserLab lab;
  lab.start();
  for (int path = 0; path < 4; ++path) {
    lab.fake.heights = some_heights(500, 3 + std::uint64_t(path));
    CHECK(lab.arm(path % 2, 500).outcome == Outcome::kReady);
    CHECK(lab.fake.surface == (path % 2 ? 0 : 1));
    CHECK(lab.fake.program == path % 2);
    CHECK(lab.fake.sampling == 5);
    CHECK(lab.fake.cycle == 3);
    CHECK_FALSE(lab.fake.communication);
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(6.0);
    const Result r = lab.collect();
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted == 500);
    const Samples s = lab.rig.all<Samples>().back();
    REQUIRE(s.z_mm.size() == 500);
    CHECK(s.material == path % 2);
    CHECK(s.damaged == 0);
    for (std::size_t n = 0; n < 500; ++n) {
      const double truth = lab.fake.heights[n];
      if (std::isnan(truth) || std::abs(truth) > 99.9999)
        CHECK(std::isnan(s.z_mm[n]));
      else
        CHECK(s.z_mm[n] == float(truth));
    }
  }
}

TEST_CASE("settings are sent when the material changes, and only then, always between Q0 and R0",
          "[laser_point]") {
  LaserLab lab;
  lab.start();
  const auto count = [&](std::string_view front) {
    return std::count_if(lab.fake.commands.begin(), lab.fake.commands.end(),
                         [&](const std::string& c) { return c.starts_with(front); });
  };
  for (const int material : {0, 0, 0, 1, 1, 0}) {
    lab.arm(material, 10);
    lab.collect();
  }
  CHECK(count("Q0") == 3);
  CHECK(count("SW,HB") == 3);
  CHECK(count("AS") == 6);
}

TEST_CASE("a full storage of 131 s is read out in the time that 115200 baud take", "[laser_point]") {
  LaserLab lab;
  lab.start();
  lab.fake.heights.assign(13'107, 1.25);
  lab.arm(0, 13'107);
  lab.fake.trigger(lab.rig.now_us);
  lab.rig.run_for(131.1);
  const std::int64_t before = lab.rig.now_us;
  CHECK(lab.collect().counted == 13'107);
  CHECK(lab.rig.now_us - before < 11'000'000);
  CHECK(lab.rig.now_us - before > 10'000'000);
}

TEST_CASE("values that come by themselves are never taken for the answer", "[laser_point]") {
  LaserLab lab;
  lab.fake.timing_before_reply = true;
  lab.start();
  for (int n = 0; n < 20; ++n) {
    lab.fake.now_mm = 0.1 * n;
    lab.command([&](std::int64_t t, Effects& fx) { lab.laser.reading(t, fx); });
    CHECK(lab.rig.all<Samples>().back().z_mm.at(0) == float(0.1 * n));
  }
  CHECK(lab.laser.timing_values() > 20);
}

TEST_CASE("an error in the settings leaves the laser measuring, the storage not armed, and is told",
          "[laser_point]") {
  for (int at = 0; at < 8; ++at) {
    LaserLab lab;
    lab.start();
    int n = 0;
    lab.rig.line = [&](std::string& said) -> std::int64_t {
      if (n++ == at) lab.fake.refuse_next = 22;
      return 0;
    };
    lab.fake.refuse_next = at == 0 ? 22 : -1;
    const Result r = lab.arm(1, 10);
    INFO("command " << at << ": " << test::describe(r));
    REQUIRE(lab.rig.run([&] { return lab.laser.safe() || lab.laser.state() == DeviceState::kArmed; }, 30));
    lab.rig.run_for(1.0);
    CHECK_FALSE(lab.fake.communication);
    if (r.outcome != Outcome::kReady) {
      CHECK(r.outcome == Outcome::kNone);
      lab.rig.line = [](std::string&) { return 0; };
      lab.fake.refuse_next = -1;
      CHECK(lab.arm(1, 10).outcome == Outcome::kReady);
      CHECK(lab.fake.surface == 0);
    }
  }
}

TEST_CASE("settings of the other material are made whatever the idle laser has just been asked",
          "[laser_point]") {
  for (std::int64_t delay_us = 0; delay_us < 3'000; delay_us += 100) {
    LaserLab lab;
    lab.start();
    REQUIRE(lab.arm(0, 10).outcome == Outcome::kReady);
    REQUIRE(lab.collect().outcome == Outcome::kDone);
    REQUIRE(lab.rig.run_past_next_request(10, delay_us));
    const Result r = lab.arm(1, 10);
    INFO(delay_us << " us after it was asked: " << test::describe(r));
    CHECK(r.outcome == Outcome::kReady);
    CHECK(lab.fake.program == 1);
    CHECK(lab.rig.all<Fault>().empty());
  }
}

TEST_CASE("a program that was not taken is told by its number, and the storage not armed", "[laser_point]") {
  LaserLab lab;
  lab.start();
  lab.rig.line = [&](std::string& said) -> std::int64_t {
    if (said.starts_with("PR,")) said = "PR,7\r";
    return 0;
  };
  const Result r = lab.arm(1, 10);
  CHECK(r.outcome == Outcome::kNone);
  CHECK(r.text == "the laser is in program 7, not in 1");
}

TEST_CASE("of what a stop interrupts no value is told", "[laser_point]") {
  for (const bool collecting : {false, true})
    for (std::int64_t delay_us = 0; delay_us < 20'000; delay_us += 250) {
      LaserLab lab;
      lab.start();
      lab.fake.heights.assign(20, 0.5);
      REQUIRE(lab.arm(0, 20).outcome == Outcome::kReady);
      lab.fake.trigger(lab.rig.now_us);
      lab.rig.run_for(1.0);
      if (!collecting) REQUIRE(lab.collect().outcome == Outcome::kDone);
      lab.rig.act([&](std::int64_t t, Effects& fx) {
        if (collecting)
          lab.laser.collect(t, fx);
        else
          lab.laser.reading(t, fx);
      });
      lab.rig.run_for(double(delay_us) * 1e-6);
      if (!lab.laser.busy()) break;
      lab.rig.events.clear();
      lab.rig.act([&](std::int64_t t, Effects& fx) { lab.laser.safe_stop(t, fx); });
      lab.rig.run_for(3.0);
      INFO((collecting ? "collect" : "reading") << ", stopped after " << delay_us << " us");
      CHECK(lab.rig.all<Samples>().empty());
      CHECK(lab.arm(1, 20).outcome == Outcome::kReady);
    }
}

TEST_CASE("what the storage or the sampling time cannot do is refused by name", "[laser_point]") {
  LaserLab lab;
  lab.start();
  const auto refused = [&](int material, int samples, double period_s) {
    const Result r =
        lab.command([&](std::int64_t t, Effects& fx) { lab.laser.arm(material, samples, period_s, t, fx); });
    CHECK(r.outcome == Outcome::kRefused);
    return r.text;
  };
  CHECK(refused(0, 65'537, 0.01).find("65536") != std::string::npos);
  CHECK(refused(0, 0, 0.01).find("[1, 65536]") != std::string::npos);
  CHECK(refused(0, 10, 0.011).find("0.011") != std::string::npos);
  CHECK(refused(2, 10, 0.01).find("material 2") != std::string::npos);
  CHECK(lab.collect().text == "nothing was armed");
  LaserPointOptions bad;
  bad.sampling_us = 300;
  CHECK_THROWS_WITH(LaserPoint(bad), Catch::Contains("sampling_us = 300"));
}

TEST_CASE("at rest the status is asked for once every poll_idle_s", "[laser_point]") {
  for (const double period_s : {0.5, 5.0, 20.0}) {
    LaserPointOptions options = slow_readings();
    options.poll_idle_s = period_s;
    LaserLab lab{options};
    lab.start();
    lab.rig.run_for(2 * period_s);
    lab.fake.commands.clear();
    lab.rig.run_for(4 * period_s + 0.1);
    CAPTURE(period_s);
    CHECK((lab.fake.commands.size() == 4 || lab.fake.commands.size() == 3));
    for (const std::string& command : lab.fake.commands) CHECK(command == "PR");
  }
}

TEST_CASE("a lost link while storing: the values are still collected, and a reset laser is set up anew",
          "[laser_point]") {
  for (const bool reset : {false, true}) {
    LaserLab lab;
    lab.start();
    lab.fake.heights.assign(300, 0.5);
    lab.arm(1, 300);
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(1.0);
    if (reset) lab.fake.reboot();
    lab.rig.close();
    lab.rig.run_for(5.0);
    REQUIRE(lab.laser.safe());
    const Result r = lab.collect();
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted == (reset ? 0 : 300));
    CHECK(lab.arm(1, 300).outcome == Outcome::kReady);
    CHECK(lab.fake.surface == 0);
  }
}

TEST_CASE("lost, late, cut and damaged replies give no value that was not measured at its place",
          "[laser_point]") {
  // Without a checksum a damaged digit cannot be seen; all else can. Bits are therefore flipped in letters
  // and signs only.
  std::uint64_t seed = 44;
  int done = 0;
  for (int round = 0; round < 60; ++round) {
    LaserLab lab;
    lab.start();
    lab.rig.line = test::lossy_line(seed, 12, 900'000, 2);
    lab.fake.heights = some_heights(50, std::uint64_t(round));
    if (lab.arm(round % 2, 50).outcome != Outcome::kReady) continue;
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(1.0);
    if (!lab.rig.run([&] { return lab.laser.safe() || lab.laser.state() == DeviceState::kArmed; }, 60))
      continue;
    const Result r = lab.collect();
    if (r.outcome != Outcome::kDone || r.counted == 0) continue;
    const Samples s = lab.rig.all<Samples>().back();
    REQUIRE(s.z_mm.size() == 50);
    ++done;
    for (std::size_t n = 0; n < 50; ++n)
      CHECK((std::isnan(s.z_mm[n]) || s.z_mm[n] == float(lab.fake.heights[n])));
  }
  CHECK(done > 40);
}
