// The path that the stage followed, as the driver reads it: from the twin, and from controllers that lose,
// damage or refuse what it asks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "plant/twins/path_follower.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/world_rig.h"
#include "tests/drivers/yes_ensemble.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::WorldRig;
using firn::drivers::test::YesEnsemble;

namespace {

constexpr double kTraceEnd_s = 1.7;

/// There and back along a slanted line, with the shutter open on the way there.
StageWay slanted_way() {
  return {{{0, 1, 2, 0, 0},
           {0.2, 1.4, 2.2, 4, 2},
           {0.7, 3.4, 3.2, 4, 2},
           {0.9, 3.8, 3.4, 0, 0},
           {1.3, 2.4, 2.7, -7, -3.5},
           {kTraceEnd_s, 1, 2, 0, 0}},
          {0.8, 2.2}};
}

plant::WorldConfig world_with_servo() {
  plant::WorldConfig c = WorldRig::small_world(4, 4);
  c.stage.servo_hz = 60.0;
  c.stage.servo_feed_forward = 0.9;
  c.stage.settle_us = 200'000;
  return c;
}

struct FollowedRig : WorldRig {
  explicit FollowedRig(StageOptions options = fast_stage()) : WorldRig(world_with_servo(), options) {
    start();
  }
  void trace() {
    begun_us = now_us;
    act("stage", [&](std::int64_t t, Effects& fx) { stage.trace(slanted_way(), 1.0, t, fx); });
  }
  Result finish() {
    REQUIRE(run([&] { return !stage.busy(); }, 60.0));
    return results("stage").back();
  }
  FollowedWay followed() const {
    const auto ways = all<FollowedWay>("stage");
    REQUIRE(ways.size() == 1);
    return ways.front();
  }
  std::string to_host(std::string_view port, std::string bytes) override {
    return port == "stage" && damage ? damage(std::move(bytes)) : bytes;
  }
  std::function<std::string(std::string)> damage;
  std::int64_t begun_us = 0;
};

}  // namespace

TEST_CASE("the followed path is what the axes did, whole, at equal times, before the result",
          "[stage][followed]") {
  FollowedRig rig;
  rig.trace();
  CHECK(rig.finish().outcome == Outcome::kDone);
  const FollowedWay way = rig.followed();
  CHECK(way.period_s == 0.01);
  REQUIRE(way.x_mm.size() == way.y_mm.size());
  CHECK(way.x_mm.size() > std::size_t(kTraceEnd_s / 0.01));
  std::vector<plant::TrackKnot> knots;
  for (const WayKnot& k : slanted_way().knots) knots.push_back({k.t_s, k.x_mm, k.y_mm, k.vx_mm_s, k.vy_mm_s});
  const plant::PathFollower truth(knots, 0, {1.0, 2.0}, world_with_servo().stage);
  double worst = 0.0;
  for (std::size_t k = 0; k < way.x_mm.size(); ++k) {
    const auto p = truth.position(std::llround(double(k) * way.period_s * 1e6));
    worst = std::max({worst, std::abs(p[0] - double(way.x_mm[k])), std::abs(p[1] - double(way.y_mm[k]))});
  }
  CHECK(worst < 1e-4);  // a count
  const auto& events = rig.events.at("stage");
  const auto at = [&](auto of) {
    return std::find_if(events.begin(), events.end(), [&](const DriverEvent& e) { return of(e); }) -
           events.begin();
  };
  CHECK(at([](const DriverEvent& e) { return event_cast<FollowedWay>(e) != nullptr; }) <
        at([](const DriverEvent& e) { return event_cast<Result>(e) != nullptr; }));
}

TEST_CASE("reading the followed path makes a run longer by the last samples alone", "[stage][followed]") {
  const auto duration_us = [](double sample_s) {
    StageOptions options = WorldRig::fast_stage();
    options.path_sample_s = sample_s;
    FollowedRig rig(options);
    rig.trace();
    REQUIRE(rig.run([&] { return rig.sent("stage", "PROGRAM RUN 1") > 0; }, 60.0));
    const std::int64_t begun_us = rig.now_us;
    rig.finish();
    return rig.now_us - begun_us;
  };
  CHECK(duration_us(0.01) - duration_us(0.0) < 50'000);
}

TEST_CASE("without path_sample_s nothing is recorded, asked for or reported", "[stage][followed]") {
  StageOptions options = WorldRig::fast_stage();
  options.path_sample_s = 0.0;
  FollowedRig rig(options);
  rig.trace();
  CHECK(rig.finish().outcome == Outcome::kDone);
  CHECK(rig.all<FollowedWay>("stage").empty());
  CHECK(rig.sent("stage", "IGLOBAL(41)") == 0);
  CHECK(rig.sent("stage", "IGLOBAL(42)") == 0);
}

TEST_CASE("a path begins in position, and one that does not settle is not begun", "[stage][followed]") {
  SECTION("it settles") {
    FollowedRig rig;
    rig.trace();
    CHECK(rig.finish().outcome == Outcome::kDone);
    const FollowedWay way = rig.followed();
    CHECK(double(way.x_mm[0]) == Approx(1.0).margin(1e-4));
  }
  SECTION("without the wait the axis is still on its way to the start") {
    StageOptions options = WorldRig::fast_stage();
    options.settle_s = 0.0;
    FollowedRig rig(options);
    rig.trace();
    rig.finish();
    CHECK(std::abs(double(rig.followed().x_mm[0]) - 1.0) > 1e-3);
  }
  SECTION("it never does") {
    StageOptions options = WorldRig::fast_stage();
    options.settle_s = 0.01;
    FollowedRig rig(options);
    rig.trace();
    const Result r = rig.finish();
    CHECK(r.outcome == Outcome::kNone);
    CHECK(r.code == kStall);
    CHECK_THAT(r.text, Catch::Contains("axis X does not settle at the start of the path"));
    CHECK(rig.sent("stage", "PROGRAM RUN 1") == 0);
  }
}

TEST_CASE("a stop goes out at once, whatever sample is awaited, lost or late", "[stage][followed][seeded]") {
  std::uint64_t seed = 7;
  for (int n = 0; n < 25; ++n) {
    CAPTURE(n);
    FollowedRig rig;
    const bool silent = n % 3 == 0, late = n % 3 == 1;
    rig.trace();
    REQUIRE(rig.run([&] { return rig.sent("stage", "PROGRAM RUN 1") > 0; }, 60.0));
    rig.run_for(0.2 + 0.001 * double(test::next(seed) % 1200));
    if (silent) rig.damage = [](std::string) { return std::string(); };
    if (late) rig.damage = [](std::string s) { return s.substr(0, s.size() / 2); };
    rig.run_for(0.001 * double(test::next(seed) % 60));
    const std::size_t before = rig.written.at("stage").size();
    rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
    const std::string burst = rig.written.at("stage").substr(before);
    CHECK(burst.starts_with("PSOCONTROL @0 OFF\n"));
    CHECK(burst.find("ABORT @0\n") != std::string::npos);
    CHECK(burst.find("DGLOBAL") == std::string::npos);
    rig.damage = nullptr;
    REQUIRE(rig.run([&] { return rig.stage.safe(); }, 60.0));
  }
}

TEST_CASE("a path whose samples are lost or damaged on the line is read as it was",
          "[stage][followed][seeded]") {
  for (std::uint64_t round = 1; round <= 12; ++round) {
    CAPTURE(round);
    FollowedRig sound, rig;
    std::uint64_t seed = round;
    rig.trace();
    REQUIRE(rig.run([&] { return rig.sent("stage", "PROGRAM RUN 1") > 0; }, 60.0));
    rig.damage = [&](std::string said) {
      if (said.find('.') == std::string::npos || test::next(seed) % 100 >= 2) return said;
      if (test::next(seed) % 2 == 0) return std::string();
      said[1] = char('0' + test::next(seed) % 10);  // the leading digit
      return said;
    };
    sound.trace();
    CHECK(sound.finish().outcome == Outcome::kDone);
    CHECK(rig.finish().outcome == Outcome::kDone);
    const FollowedWay a = rig.followed(), b = sound.followed();
    REQUIRE(a.x_mm.size() == b.x_mm.size());
    int wrong = 0;
    for (std::size_t k = 0; k < a.x_mm.size(); ++k)
      wrong += std::abs(a.x_mm[k] - b.x_mm[k]) > 1e-4f || std::abs(a.y_mm[k] - b.y_mm[k]) > 1e-4f;
    CHECK(wrong <= 2);  // a digit that is wrong by less than the stage can move is not seen
  }
}

TEST_CASE("a controller that refuses samples is told of, and the path is done without them",
          "[stage][followed]") {
  FollowedRig rig;
  rig.trace();
  REQUIRE(rig.run([&] { return rig.sent("stage", "PROGRAM RUN 1") > 0; }, 60.0));
  rig.damage = [](std::string said) { return said.find('.') != std::string::npos ? "!\n" : said; };
  const Result r = rig.finish();
  CHECK(r.outcome == Outcome::kDone);
  CHECK(r.counted == 2);
  CHECK(rig.followed().x_mm.empty());
  const auto faults = rig.all<Fault>("stage");
  CHECK(std::any_of(faults.begin(), faults.end(), [](const Fault& f) {
    return f.severity == Severity::kWarning &&
           f.text.find("the followed path is not recorded") != f.text.npos;
  }));
}

TEST_CASE("samples of a path too long for the controller's memory are farther apart", "[stage][followed]") {
  YesEnsemble e{StageOptions{}};
  const auto sent = [&](const char* line) {
    return std::find(e.log.begin(), e.log.end(), line) != e.log.end();
  };
  StageWay way = slanted_way();
  way.knots.back().t_s = 400.0;
  e.bench.command([&](std::int64_t t, Effects& fx) { e.stage.trace(way, 1.0, t, fx); });
  e.run([&] { return sent("PROGRAM RUN 1, \"FirnPath.bcx\""); });
  CHECK(sent("IGLOBAL(41)=49"));  // 400.1 s over 8,177 samples
  CHECK(sent("IGLOBAL(42)=0"));
}
