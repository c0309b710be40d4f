// The robot's driver against a fake V+ program: executed paths, their number, and the driver's reports.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/drivers/bench.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/robot_lab.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::Severity;
using firn::drivers::test::FakeRobot;
using firn::drivers::test::next;
using firn::drivers::test::sweep;
using Lab = firn::drivers::test::RobotLab;

namespace {

const std::string kRobotTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

}  // namespace

TEST_CASE("the robot's driver speaks as its card says, whatever the split of the replies", "[robot]") {
  for (const std::size_t split : {0, 1, 2, 7}) {
    RobotOptions options;
    options.poll_moving_s = 0.5;
    Robot robot{options};
    test::play(
        robot, kRobotTranscripts + "fvp_run_path.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) {
          if (c == "home")
            robot.home(t, fx);
          else if (c == "path")
            robot.add_path(7, 0.016, 4, sweep(4, 0.1, 20.0), t, fx);
          else if (c == "run")
            robot.run({7, 0, 0}, kSignalValveB, t, fx);
          else
            FAIL("no command " << c);
        },
        split);
  }
}

TEST_CASE("a path is run whatever the idle robot has just been asked", "[robot]") {
  for (std::int64_t delay_us = 0; delay_us < 3'000; delay_us += 100) {
    Lab lab;
    lab.start();
    lab.give(1, sweep(100));
    lab.rig.run_for(5.0);
    REQUIRE(lab.rig.run_past_next_request(10, delay_us));
    INFO(delay_us << " us after it was asked");
    CHECK(lab.run(1).outcome == Outcome::kDone);
    CHECK(lab.rig.all<Fault>().empty());
  }
}

TEST_CASE("every point of every path arrives, once, and is run with its signals", "[robot]") {
  Lab lab;
  lab.start();
  std::uint64_t seed = 4;
  for (int p = 1; p <= 12; ++p) lab.give(p, sweep(2 + next(seed) % 700, 0.05 * p, 10.0 + p));
  for (int p = 1; p <= 12; ++p) {
    const Result r = lab.run(p, p % 2 ? kSignalValveA : kSignalLaser);
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted == r.expected);
    CHECK(lab.rig.all<Fault>().empty());
  }
  REQUIRE(lab.fake.runs.size() == 12);
  seed = 4;
  for (int p = 1; p <= 12; ++p) {
    const std::vector<double> q = sweep(2 + next(seed) % 700, 0.05 * p, 10.0 + p);
    const FakeRobot::Run& run = lab.fake.runs[std::size_t(p - 1)];
    REQUIRE(run.points.size() == q.size() / 4);
    CHECK(run.signals == (p % 2 ? kSignalValveA : kSignalLaser));
    CHECK(run.finished);
    for (std::size_t n = 0; n < run.points.size(); ++n) {
      const fvp::Joints back = fvp::joints_of(run.points[n]);
      for (std::size_t j = 0; j < 4; ++j)
        CHECK(std::abs(back[j] - q[4 * n + j]) <=
              (j == 2 ? 0.0005 : 0.5e-4 * std::numbers::pi / 180) * 1.0001);
    }
  }
}

TEST_CASE("the next path is uploaded while one runs, so that its load is answered at once", "[robot]") {
  Lab lab;
  lab.start();
  for (int p = 1; p <= 4; ++p) lab.give(p, sweep(600, 0.1));
  lab.begin(1);
  REQUIRE(lab.rig.run([&] { return lab.robot.holds({2, 0, 599}); }, 9));
  CHECK(lab.robot.busy());  // path 1 is still under way
  REQUIRE(lab.rig.run([&] { return !lab.robot.busy(); }, 20));
  const std::int64_t before = lab.rig.now_us;
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.robot.load({2, 0, 0}, t, fx); });
  REQUIRE(lab.rig.run([&] { return !lab.robot.busy(); }, 5));
  CHECK(lab.rig.now_us - before < 5000);
  CHECK(lab.rig.all<Result>().back().outcome == Outcome::kDone);
}

TEST_CASE("a path longer than the robot's memory is refused whole and run in parts", "[robot]") {
  Lab lab;
  lab.start();
  const std::vector<double> q = sweep(9000);
  lab.give(1, q);
  CHECK(lab.run(1).outcome == Outcome::kRefused);
  CHECK(lab.rig.all<Result>().back().text.find("8192") != std::string::npos);
  for (const PathPart part : {PathPart{1, 0, 4000}, PathPart{1, 4000, 0}}) {
    lab.rig.act([&](std::int64_t t, Effects& fx) { lab.robot.run(part, kSignalValveA, t, fx); });
    REQUIRE(lab.rig.run([&] { return !lab.robot.busy(); }, 200));
    CHECK(lab.rig.all<Result>().back().outcome == Outcome::kDone);
  }
  REQUIRE(lab.fake.runs.size() == 2);
  CHECK(lab.fake.runs[0].points.size() == 4001);
  CHECK(lab.fake.runs[1].points.size() == 5000);
  CHECK(lab.fake.runs[0].points.back() == lab.fake.runs[1].points.front());
}

TEST_CASE("interlock 8: what a joint cannot do is refused by name before anything is sent", "[robot][I8]") {
  struct Case {
    std::size_t at;
    double value;
    const char* text;
  };
  for (const Case& c :
       {Case{4 * 5 + 0, 1.9, "sample 5: J1 = 108.8620 deg is outside"}, Case{4 * 7 + 1, -2.7, "sample 7: J2"},
        Case{4 * 2 + 2, -0.1, "sample 2: J3 = -0.100 mm"}, Case{4 * 3 + 3, std::nan(""), "sample 3: J4"},
        Case{4 * 9 + 0, 0.9, "J1 would turn at"}}) {
    Lab lab;
    lab.start();
    std::vector<double> q = sweep(20);
    q[c.at] = c.value;
    const std::int64_t sent = lab.rig.bytes_sent;
    lab.give(1, q);
    CHECK(lab.rig.bytes_sent == sent);
    CHECK(lab.rig.faulted(kUnreachable));
    const Result r = lab.run(1);
    CHECK(r.outcome == Outcome::kRefused);
    INFO(r.text);
    CHECK(r.text.find(c.text) != std::string::npos);
    CHECK(lab.fake.runs.empty());
  }
  Lab lab;
  lab.start();
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.robot.add_path(1, 0.008, 4, sweep(20), t, fx); });
  CHECK(lab.run(1).text.find("tick") != std::string::npos);
  CHECK(lab.run(2).text.find("has not been received") != std::string::npos);
}

TEST_CASE(
    "interlock 7: a path that takes a tick more than planned is told, and stops the print the second time",
    "[robot]") {
  for (const std::int64_t slip_us : {-15'000, 15'000, 17'000, 40'000}) {
    Lab lab;
    lab.start();
    lab.fake.slip_us = slip_us;
    lab.give(1, sweep(100));
    lab.give(2, sweep(100));
    const bool told = slip_us > 16'000;
    CHECK(lab.run(1).code == (told ? kTimeSlip : kNoCode));
    CHECK(lab.rig.faulted(kTimeSlip) == told);
    if (told) {
      const firn::Figure slip = lab.rig.all<Fault>().back().figure;
      CHECK(slip.value == double(slip_us) * 1e-3);
      CHECK(slip.limit == 16.0);
      CHECK(slip.unit == "ms");
      CHECK(slip.key == "ice.max_time_slip_s");
    }
    const Result r = lab.run(2);
    CHECK(r.outcome == Outcome::kDone);
    CHECK(r.counted - r.expected == slip_us);
    if (told) CHECK(lab.rig.all<Fault>().back().severity == Severity::kStop);
  }
}

TEST_CASE("interlock 7: a monitor speed other than 100 is put right by homing, else nothing runs",
          "[robot][I7]") {
  Lab lab;
  lab.start();
  lab.give(1, sweep(100));
  lab.fake.status.speed_percent = 50;
  lab.rig.run_for(2.0);
  CHECK(lab.run(1).code == kTimeSlip);
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.robot.home(t, fx); });
  REQUIRE(lab.rig.run([&] { return !lab.robot.busy(); }, 30));
  CHECK(lab.run(1).outcome == Outcome::kDone);
}

TEST_CASE("interlock 5: a path that does not end is stopped, with what it has done", "[robot][I5]") {
  Lab lab;
  lab.start();
  lab.give(1, sweep(101));
  lab.fake.slip_us = 60'000'000;
  const Result r = lab.run(1, kSignalValveA, 20);
  CHECK(r.outcome == Outcome::kFailed);
  CHECK(r.code == kStall);
  CHECK(lab.rig.faulted(kStall));
  CHECK(lab.fake.signals == 0);
  REQUIRE(lab.rig.run([&] { return lab.robot.safe(); }, 10));
  CHECK(lab.robot.joints().value()[2] > 29.0);  // raised
  CHECK(lab.run(1).outcome == Outcome::kRefused);
}

TEST_CASE("a safe stop drops the signals first, then stops, raises the tool and tells the prefix",
          "[robot]") {
  std::uint64_t seed = 8;
  for (int round = 0; round < 30; ++round) {
    Lab lab;
    lab.start();
    lab.give(1, sweep(500));
    lab.begin(1);
    lab.rig.run_for(double(next(seed) % 9000) * 1e-3);
    const bool was_busy = lab.robot.busy();
    const std::size_t before = lab.fake.requests.size();
    lab.rig.act([&](std::int64_t t, Effects& fx) { lab.robot.safe_stop(t, fx); });
    REQUIRE(lab.rig.run([&] { return lab.robot.safe() && !lab.robot.busy(); }, 10));
    CHECK(lab.fake.requests[before] == "SIG 0");
    CHECK(lab.fake.requests[before + 1] == "STOP");
    CHECK(lab.fake.signals == 0);
    CHECK_FALSE(lab.fake.moving);
    const Result r = lab.rig.all<Result>().back();
    if (!was_busy) continue;
    const std::int64_t passed = lab.fake.runs.empty() ? 0 : (lab.fake.status.at - 1) * 16'000;
    CHECK(r.counted == passed);
    CHECK(r.outcome == (lab.fake.runs.empty() ? Outcome::kNone : Outcome::kFailed));
    // a path that has begun is never begun again; a path that has not may be
    const Result again = lab.run(1);
    CHECK(again.outcome ==
          (lab.fake.runs.size() == 1 && r.outcome == Outcome::kFailed ? Outcome::kRefused : Outcome::kDone));
    CHECK(lab.fake.runs.size() == 1);
  }
}

TEST_CASE("no reply three times with the same number is a lost link, and 0.75 s long", "[robot]") {
  Lab lab;
  lab.start();
  lab.rig.run_for(0.3);
  lab.rig.hung = lab.rig.unplugged = true;
  const std::int64_t quiet_us = lab.rig.now_us;
  REQUIRE(lab.rig.run([&] { return lab.robot.state() == DeviceState::kDisconnected; }, 5));
  CHECK(lab.rig.now_us - quiet_us <= 1'000'000 + 750'000);
}

TEST_CASE("lost, late, cut and damaged replies lose no point, run nothing twice and shift no answer",
          "[robot]") {
  std::uint64_t seed = 21;
  int done = 0;
  for (int round = 0; round < 40; ++round) {
    Lab lab;
    lab.start();
    lab.rig.split = round % 4 == 0 ? 1 : 0;
    lab.rig.line = test::lossy_line(seed, 5 + next(seed) % 20, 400'000);
    for (int p = 1; p <= 5; ++p) lab.give(p, sweep(300, 0.1 * p));
    for (int p = 1; p <= 5; ++p) {
      const Result r = lab.run(p);
      INFO("round " << round << " path " << p << ": " << test::describe(r));
      if (r.outcome == Outcome::kDone) {
        ++done;
        CHECK(std::abs(r.counted - 299 * 16'000) <= 1000);
        REQUIRE(lab.fake.runs.back().points.size() == 300);
        CHECK(lab.fake.runs.back().points.front() == fvp::counts_of({0.1 * p, -0.5, 20.0, 0.4}));
      }
      if (r.outcome == Outcome::kNone)
        CHECK((lab.fake.runs.empty() ||
               lab.fake.runs.back().points.front() != fvp::counts_of({0.1 * p, -0.5, 20.0, 0.4})));
      REQUIRE(lab.rig.run([&] { return lab.robot.safe(); }, 60));
      if (!lab.fake.status.calibrated) break;
    }
    CHECK(lab.fake.runs.size() <= 5);
    for (std::size_t a = 0; a < lab.fake.runs.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        CHECK(lab.fake.runs[a].points.front() != lab.fake.runs[b].points.front());
  }
  CHECK(done > 100);
}

TEST_CASE(
    "a driver that was killed says on its return what the robot has truly done, and never runs it again",
    "[robot]") {
  std::uint64_t seed = 33;
  int finished = 0, cut = 0, none = 0, unknown = 0;
  for (int round = 0; round < 60; ++round) {
    Lab lab;
    lab.start();
    lab.give(1, sweep(200));
    lab.begin(1);
    lab.rig.run_for(double(next(seed) % 4600) * 1e-3);
    if (!lab.robot.busy()) continue;
    const bool reboots = round % 5 == 0;
    lab.rig.hung = lab.rig.unplugged = true;  // nobody listens while it is dead
    const std::int64_t dead_us = std::int64_t(next(seed) % 3'000'000);
    const std::size_t runs = lab.fake.runs.size();
    lab.rig.now_us += dead_us;
    lab.fake.advance(lab.rig.now_us);
    lab.fake.out.clear();
    if (reboots) lab.fake.reboot();
    lab.rig.hung = lab.rig.unplugged = false;
    lab.rig.close();
    REQUIRE(lab.rig.run([&] { return !lab.robot.busy() && lab.robot.safe(); }, 30));
    REQUIRE(lab.rig.all<Result>().size() == 1);
    const Result r = lab.rig.all<Result>().back();
    INFO(test::describe(r));
    CHECK(lab.fake.runs.size() == runs);
    if (runs == 0) {
      ++none;
      CHECK((r.outcome == Outcome::kNone || (reboots && r.outcome == Outcome::kUnknown)));
    } else if (reboots) {
      ++unknown;
      CHECK((r.outcome == Outcome::kUnknown && r.unknown_to == 199 * 16'000));
    } else if (lab.fake.runs.back().finished) {
      ++finished;
      CHECK(r.outcome == Outcome::kDone);
      CHECK(r.counted == 199 * 16'000);
    } else {
      ++cut;
      CHECK(r.outcome == Outcome::kFailed);
      CHECK(r.counted == (lab.fake.status.at - 1) * 16'000);
    }
    if (!reboots && runs > 0) CHECK(lab.run(1).outcome == Outcome::kRefused);
  }
  CHECK(finished > 3);
  CHECK(cut > 3);
  CHECK(none > 3);
  CHECK(unknown > 0);
}

TEST_CASE("events may be lost: the status says the same", "[robot]") {
  Lab lab;
  lab.fake.silent_events = true;
  lab.start();
  lab.give(1, sweep(200));
  const Result r = lab.run(1);
  CHECK(r.outcome == Outcome::kDone);
  CHECK(r.counted == r.expected);
  CHECK(lab.rig.all<Fault>().empty());
}

TEST_CASE("while a path runs the robot hears its host every 200 ms", "[robot]") {
  Lab lab;
  lab.start();
  lab.give(1, sweep(2000));
  lab.begin(1);
  REQUIRE(lab.rig.run([&] { return lab.fake.status.running != 0; }, 10));
  std::int64_t last_us = lab.rig.now_us, longest_us = 0;
  std::size_t heard = lab.fake.requests.size();
  while (lab.fake.status.running != 0) {
    lab.rig.run([&] { return lab.fake.requests.size() != heard || lab.fake.status.running == 0; }, 2.0);
    heard = lab.fake.requests.size();
    longest_us = std::max(longest_us, lab.rig.now_us - last_us);
    last_us = lab.rig.now_us;
  }
  CHECK(longest_us <= 210'000);
}
