// The valve's driver against a fake of its firmware: fired pulses, their number, and the driver's reports.
#include <catch2/catch.hpp>

#include "drivers/valve/valve.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/fake_rig.h"
#include "tests/drivers/fake_valve.h"
#include "tests/drivers/lossy_line.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::FakeValve;
using firn::drivers::test::next;

namespace {

const std::string kValveTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";
using ValveRig = test::FakeRig<Valve, FakeValve>;

std::vector<std::int32_t> every_pulse(int n, int ticks = 4) {
  std::vector<std::int32_t> list;
  for (int k = 0; k < n; ++k) list.push_back(k * ticks);
  return list;
}

struct ValveLab {
  FakeValve fake;
  Valve valve;
  ValveRig rig;

  explicit ValveLab(ValveOptions config = {}) : valve(config), rig(valve, fake) { rig.lines = false; }

  void start() {
    rig.open();
    REQUIRE(rig.run([&] { return valve.safe(); }, 10));
    rig.events.clear();
  }
  void give(std::int64_t path, const std::vector<std::int32_t>& list, double pulse_s = 0.00125) {
    rig.act([&](std::int64_t t, Effects& fx) { valve.add_list({path, 0}, 0.002, pulse_s, list, t, fx); });
  }
  template <class F>
  Result command(F&& f, double limit_s = 200) {
    rig.act(f);
    REQUIRE(rig.run([&] { return !valve.busy(); }, limit_s));
    return rig.all<Result>().back();
  }
  Result load(std::int64_t path) {
    return command([&](std::int64_t t, Effects& fx) { valve.load({path, 0}, t, fx); });
  }
  Result arm(std::int64_t path) {
    return command([&](std::int64_t t, Effects& fx) { valve.arm({path, 0}, t, fx); });
  }
  Result disarm() {
    return command([&](std::int64_t t, Effects& fx) { valve.disarm(t, fx); });
  }
};

}  // namespace

TEST_CASE("the valve's driver speaks as its card says, whatever the split of the replies", "[valve]") {
  for (const std::size_t split : {0, 1, 3}) {
    Valve valve{ValveOptions{}};
    test::play(
        valve, kValveTranscripts + "fvb_fire_list.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) {
          if (c == "list")
            valve.add_list({5, 0}, 0.002, 0.00125, std::vector<std::int32_t>{0, 4, 1000}, t, fx);
          else if (c == "load")
            valve.load({5, 0}, t, fx);
          else if (c == "arm")
            valve.arm({5, 0}, t, fx);
          else if (c == "disarm")
            valve.disarm(t, fx);
          else
            FAIL("no command " << c);
        },
        split);
  }
}

TEST_CASE("a list is armed and fired whatever the idle valve has just been asked", "[valve]") {
  for (std::int64_t delay_us = 0; delay_us < 3'000; delay_us += 100) {
    ValveLab lab;
    lab.start();
    lab.give(1, every_pulse(20));
    REQUIRE(lab.load(1).outcome == Outcome::kDone);
    REQUIRE(lab.rig.run_past_next_request(10, delay_us));
    INFO(delay_us << " us after it was asked");
    CHECK(lab.arm(1).outcome == Outcome::kReady);
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(1.0);
    const Result r = lab.disarm();
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted == 20);
    CHECK(lab.rig.all<Fault>().empty());
  }
}

TEST_CASE("every list is fired once and its pulses are counted", "[valve]") {
  ValveLab lab;
  lab.start();
  std::uint64_t seed = 2;
  std::size_t fired = 0;
  for (int p = 1; p <= 8; ++p) lab.give(p, every_pulse(1 + int(next(seed) % 2000)));
  seed = 2;
  for (int p = 1; p <= 8; ++p) {
    const std::vector<std::int32_t> list = every_pulse(1 + int(next(seed) % 2000));
    CHECK(lab.load(p).outcome == Outcome::kDone);
    CHECK(lab.arm(p).outcome == Outcome::kReady);
    CHECK(lab.valve.state() == DeviceState::kArmed);
    lab.rig.run_for(0.7);
    REQUIRE(std::equal(list.begin(), list.end(), lab.fake.list.begin(), lab.fake.list.end()));
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(double(list.back()) * 0.002 + 0.1);
    const Result r = lab.disarm();
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted == std::int64_t(list.size()));
    CHECK(lab.valve.safe());
    fired += list.size();
    CHECK(lab.fake.shots_us.size() == fired);
    CHECK(lab.arm(p).outcome == Outcome::kRefused);
  }
}

TEST_CASE("the next list goes over as soon as the controller is free", "[valve]") {
  ValveLab lab;
  lab.start();
  lab.give(1, every_pulse(2000));
  lab.give(2, every_pulse(16'384, 1), 0.0005);
  lab.rig.run_for(1.0);
  CHECK(lab.valve.holds({1, 0}));
  lab.arm(1);
  lab.fake.trigger(lab.rig.now_us);
  lab.rig.run_for(17.0);
  lab.disarm();
  lab.rig.run_for(1.0);
  CHECK(lab.valve.holds({2, 0}));
  const std::int64_t before = lab.rig.now_us;
  CHECK(lab.load(2).outcome == Outcome::kDone);
  CHECK(lab.rig.now_us == before);
}

TEST_CASE("a clock that runs slow is given the time for its last pulses", "[valve]") {
  for (const double clock : {1.0 - 2e-4, 1.0 + 2e-4}) {
    ValveLab lab;
    lab.start();
    lab.fake.clock = clock;
    lab.give(1, every_pulse(10'000));
    lab.load(1);
    lab.arm(1);
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(9999 * 0.008 + 0.002);
    const Result r = lab.disarm();
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted == 10'000);
  }
}

TEST_CASE("what the data type or the valve cannot do is refused by name and nothing is sent",
          "[valve][I14]") {
  struct Case {
    std::vector<std::int32_t> list;
    double pulse_s;
    const char* text;
  };
  for (const Case& c : {Case{every_pulse(16'385, 1), 0.0005, "16385 pulses are outside [1, 16384]"},
                        Case{{}, 0.00125, "0 pulses"}, Case{{0, 65'536}, 0.00125, "tick 65536"},
                        Case{{5, 4}, 0.00125, "pulse 1 begins -2000 us"},
                        Case{{4, 4}, 0.00125, "pulse 1 begins 0 us"}, Case{{0, 1}, 0.00195, "2050 us"},
                        Case{{0, 4}, 0.0004, "a pulse of 0.4"}, Case{{-1, 4}, 0.00125, "tick -1"}}) {
    ValveLab lab;
    lab.start();
    const std::int64_t sent = lab.rig.bytes_sent;
    lab.give(1, c.list, c.pulse_s);
    CHECK(lab.rig.bytes_sent == sent);
    CHECK(lab.rig.faulted(kLimit));
    const Result r = lab.load(1);
    CHECK(r.outcome == Outcome::kRefused);
    INFO(r.text);
    CHECK(r.text.find(c.text) != std::string::npos);
  }
}

TEST_CASE("interlock 3: a controller that was reset has lost its list, and what it fired is in doubt",
          "[valve][I3]") {
  for (const double after_s : {0.0, 1.0, 5.0}) {
    ValveLab lab;
    lab.start();
    lab.give(1, every_pulse(2000));
    lab.give(2, every_pulse(10));
    lab.load(1);
    lab.arm(1);
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(after_s);
    lab.fake.reboot();
    REQUIRE(lab.rig.run([&] { return lab.rig.faulted(kValveLost); }, 1.0));
    const std::vector<StateChange> states = lab.rig.all<StateChange>();
    CHECK(std::any_of(states.begin(), states.end(),
                      [](const StateChange& s) { return s.state == DeviceState::kFault; }));
    REQUIRE(lab.rig.run([&] { return lab.valve.safe(); }, 10));
    const Result r = lab.disarm();
    CHECK(r.outcome == Outcome::kUnknown);
    CHECK(r.unknown_from <= std::int64_t(lab.fake.shots_us.size()));
    CHECK(r.unknown_to == 2000);
    CHECK(lab.arm(1).outcome == Outcome::kRefused);
    lab.load(2);
    CHECK(lab.arm(2).outcome == Outcome::kReady);
  }
}

TEST_CASE("a safe stop closes the valve with its first byte, and the count is exact", "[valve]") {
  std::uint64_t seed = 6;
  for (int round = 0; round < 30; ++round) {
    ValveLab lab;
    lab.start();
    lab.give(1, every_pulse(500));
    lab.load(1);
    lab.arm(1);
    if (round % 5) lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(double(next(seed) % 5000) * 1e-3);
    const std::size_t before = lab.fake.requests.size();
    lab.rig.act([&](std::int64_t t, Effects& fx) { lab.valve.safe_stop(t, fx); });
    CHECK(lab.fake.requests[before] == fvb::Type::kDisarm);
    const std::size_t shots = lab.fake.shots_us.size();
    REQUIRE(lab.rig.run([&] { return lab.valve.safe(); }, 5));
    lab.rig.run_for(3.0);
    CHECK(lab.fake.shots_us.size() == shots);
    if (shots > 0) CHECK(lab.arm(1).outcome == Outcome::kRefused);
    const Result r = lab.disarm();
    CHECK(r.counted == std::int64_t(shots));
    CHECK(r.outcome == (shots == 0 ? Outcome::kNone : shots == 500 ? Outcome::kDone : Outcome::kFailed));
    CHECK(lab.load(1).outcome == (shots == 0 ? Outcome::kDone : Outcome::kRefused));
  }
}

TEST_CASE("a lost link while it fires: the firmware closes it, and the count is read when it is heard again",
          "[valve]") {
  std::uint64_t seed = 16;
  for (int round = 0; round < 20; ++round) {
    ValveLab lab;
    lab.start();
    lab.give(1, every_pulse(1000));
    lab.load(1);
    lab.arm(1);
    lab.fake.trigger(lab.rig.now_us);
    lab.rig.run_for(double(next(seed) % 3000) * 1e-3);
    if (round % 2) lab.rig.act([&](std::int64_t t, Effects& fx) { lab.valve.disarm(t, fx); });
    const bool in_command = lab.valve.busy();
    lab.rig.hung = lab.rig.unplugged = true;
    lab.rig.run_for(3.0 + double(next(seed) % 3000) * 1e-3);
    lab.fake.advance(lab.rig.now_us);
    lab.rig.hung = lab.rig.unplugged = false;
    REQUIRE(lab.rig.run([&] { return lab.valve.safe() && !lab.valve.busy(); }, 20));
    CHECK(lab.rig.faulted(kLinkLost));
    const Result r = in_command ? lab.rig.all<Result>().back() : lab.disarm();
    CHECK(r.counted == std::int64_t(lab.fake.shots_us.size()));
    CHECK(r.outcome != Outcome::kUnknown);
    CHECK(lab.fake.shots_us.size() < 700);
  }
}

TEST_CASE("lost, late, cut and damaged replies lose no pulse, fire nothing twice and falsify no count",
          "[valve]") {
  std::uint64_t seed = 26;
  int done = 0;
  for (int round = 0; round < 40; ++round) {
    ValveLab lab;
    lab.start();
    lab.rig.split = round % 4 == 0 ? 1 : 0;
    lab.rig.line = test::lossy_line(seed, 15, 500'000);
    for (int p = 1; p <= 4; ++p) lab.give(p, every_pulse(600));
    for (int p = 1; p <= 4; ++p) {
      const std::size_t before = lab.fake.shots_us.size();
      if (lab.load(p).outcome != Outcome::kDone) break;
      if (lab.arm(p).outcome != Outcome::kReady) break;
      lab.fake.trigger(lab.rig.now_us);
      lab.rig.run_for(600 * 0.008 + 0.1);
      REQUIRE(lab.rig.run(
          [&] {
            return lab.valve.state() != DeviceState::kDisconnected &&
                   lab.valve.state() != DeviceState::kConnecting &&
                   lab.valve.state() != DeviceState::kIdentifying;
          },
          60));
      const Result r = lab.disarm();
      INFO("round " << round << " list " << p << ": " << test::describe(r));
      if (r.outcome == Outcome::kRefused) break;  // the link was just lost
      CHECK(r.counted == std::int64_t(lab.fake.shots_us.size() - before));
      done += r.outcome == Outcome::kDone;
    }
    CHECK(lab.fake.shots_us.size() <= 4 * 600);
  }
  CHECK(done > 100);
}

TEST_CASE("a list that does not verify is sent again, three times at most", "[valve]") {
  for (const int bad : {1, 2, 3, 9}) {
    ValveLab lab;
    lab.fake.corrupt_ends = bad;
    lab.start();
    lab.give(1, every_pulse(300));
    lab.rig.run_for(0.5);
    const Result r = lab.load(1);
    CHECK(r.outcome == (bad < 3 ? Outcome::kDone : Outcome::kRefused));
  }
}
