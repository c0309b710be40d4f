// The lamp's status bits against its twin: nothing is exposed with a lamp that is out or cold, and a shutter
// that does not move is named.
#include <catch2/catch.hpp>

#include "tests/drivers/bench.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::WorldRig;
using plant::FaultKind;

namespace {

enum Trip : std::int64_t { kMended, kAlarm, kOut, kStuckClosed, kStuckOpen };

struct LampRig : WorldRig {
  explicit LampRig(LampOptions options = {}, double warm_up_s = 1.0)
      : WorldRig(cold_world(warm_up_s), fast_stage(), std::move(options)) {
    start();
    REQUIRE(run([&] { return lamp.safe(); }, 10.0));
  }
  static plant::WorldConfig cold_world(double warm_up_s) {
    plant::WorldConfig c = small_world(4, 4);
    c.lamp.warm_up_us = std::int64_t(warm_up_s * 1e6);
    return c;
  }
  void trip(Trip code) { world.inject({"lamp", FaultKind::kTrip, code, 0}, now_us); }
  Result expose(double exposure_s, double limit_s = 30.0) {
    act("lamp", [&](std::int64_t t, Effects& fx) { lamp.expose(exposure_s, 80, t, fx); });
    REQUIRE(run([&] { return !lamp.busy(); }, limit_s));
    return results("lamp").back();
  }
  bool stopped_by(std::string_view text) const {
    for (const Fault& f : all<Fault>("lamp"))
      if (f.severity == Severity::kStop && f.code == kLampOn && f.text.find(text) != std::string::npos)
        return true;
    return false;
  }
  double dose_s() const {
    const auto& events = record.history.lamp;
    return events.empty() ? 0.0 : events.back().dose_s;
  }
};

}  // namespace

TEST_CASE("a lamp that burns and is warm exposes as long as it was told, by its own bits", "[lamp]") {
  for (const double s : {0.05, 0.1, 0.5, 2.0, 3.14159}) {
    LampRig rig;
    CHECK(rig.expose(s).outcome == Outcome::kDone);
    CHECK(rig.dose_s() == Approx(0.8 * s).margin(0.02));
    CHECK(rig.all<Fault>("lamp").empty());
  }
}

TEST_CASE("a lamp that is out is switched on once and waited for until it is warm",
          "[lamp][corrected:lamp-on]") {
  LampRig rig({}, 4.0);
  rig.trip(kOut);
  const std::int64_t begin_us = rig.now_us;
  CHECK(rig.expose(0.5).outcome == Outcome::kDone);
  CHECK(rig.now_us - begin_us > 4'000'000);
  CHECK(rig.dose_s() == Approx(0.4).margin(0.02));
  CHECK(rig.sent("lamp", "TON") == 1);
}

TEST_CASE("a lamp that is out and may not be switched on is named, and its shutter stays closed",
          "[lamp][I9][corrected:lamp-status]") {
  LampOptions options;
  options.auto_on = OnOff::kOff;
  LampRig rig(options);
  rig.trip(kOut);
  const Result r = rig.expose(0.5);
  CHECK(r.outcome == Outcome::kNone);
  CHECK(r.code == kLampOn);
  CHECK(rig.stopped_by("it does not burn"));
  CHECK(rig.record.history.lamp.empty());
}

TEST_CASE("a lamp that does not get warm is named when its time is over", "[lamp][I9]") {
  LampOptions options;
  options.warm_up_s = 5.0;
  LampRig rig(options, 60.0);
  rig.trip(kOut);
  CHECK(rig.expose(0.5).outcome == Outcome::kNone);
  CHECK(rig.stopped_by("it is not warm"));
}

TEST_CASE("a lamp with an alarm is not exposed with", "[lamp][I9]") {
  LampRig rig;
  rig.trip(kAlarm);
  CHECK(rig.expose(0.5).outcome == Outcome::kNone);
  CHECK(rig.stopped_by("it has an alarm"));
}

TEST_CASE("a shutter that does not open is named, however short the exposure",
          "[lamp][I9][corrected:lamp-shutter]") {
  for (const double s : {0.05, 0.3, 0.5, 3.0}) {
    LampRig rig;
    rig.trip(kStuckClosed);
    const Result r = rig.expose(s);
    CHECK(r.outcome == Outcome::kFailed);
    CHECK(r.code == kLampOn);
    CHECK(rig.stopped_by("shutter"));
  }
}

TEST_CASE("a shutter that does not close is named half a second after it was told", "[lamp][I9]") {
  LampRig rig;
  rig.act("lamp", [&](std::int64_t t, Effects& fx) { rig.lamp.expose(1.0, 80, t, fx); });
  rig.run_for(0.5);
  rig.trip(kStuckOpen);
  REQUIRE(rig.run([&] { return rig.stopped_by("the shutter does not close"); }, 10.0));
  CHECK(rig.lamp.may_be_open());
  CHECK(rig.now_us > 1'500'000);
  rig.trip(kMended);
  REQUIRE(rig.run([&] { return rig.lamp.safe() && !rig.lamp.may_be_open(); }, 30.0));
}

TEST_CASE("without the status bits a lamp that is out exposes nothing and nobody knows", "[lamp]") {
  LampOptions options;
  options.status_bits = OnOff::kOff;
  LampRig rig(options);
  rig.trip(kOut);
  CHECK(rig.expose(0.5).outcome == Outcome::kDone);
  CHECK(rig.dose_s() == 0.0);
}
