// The heaters' driver: set points, and interlock 10 row by row against heaters that fail.
#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/heater/heater.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/fake_rig.h"
#include "tests/drivers/lossy_line.h"
#include "tests/support/thermostat_box.h"

using namespace firn::drivers;
using firn::Outcome;
using firn::Severity;
using firn::drivers::test::next;

namespace {

const std::string kHeaterTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

// Three first-order heaters with ON/OFF controllers and a reading of 0.01 degC.
class FakeHeaters {
 public:
  void take(std::string_view bytes, std::int64_t now_us) {
    advance(now_us);
    for (const char c : bytes) {
      line_ += c;
      if (c != '\n') continue;
      const std::string line = std::exchange(line_, {});
      const auto text = checked_text(line, 0);
      if (!text) continue;
      LineWriter reply;
      if (*text == "T?") {
        thermostat::Reading r;
        for (std::size_t n = 0; n < 3; ++n) {
          r.celsius[n] = open[n] ? std::nan("") : frozen[n] ? frozen_at[n] : celsius[n];
          r.heating[n] = relay[n];
        }
        put(reply, r);
      } else if (const auto set = thermostat::parse_set_point(*text)) {
        set_celsius[std::size_t(set->channel - 1)] = set->c100 / 100.0;
        reply.text(*text);
      } else {
        reply.text("E,21");
      }
      out += reply.finish(0);
    }
  }
  void advance(std::int64_t now_us) {
    for (; t_us_ + 100'000 <= now_us; t_us_ += 100'000)
      for (std::size_t n = 0; n < 3; ++n) {
        if (celsius[n] < set_celsius[n] - 0.5) relay[n] = true;
        if (celsius[n] > set_celsius[n] + 0.5) relay[n] = false;
        const bool hot = stuck_on[n] || (relay[n] && !dead[n]);
        celsius[n] += 0.1 * ((hot ? 2.0 : 0.0) - (celsius[n] + 20.0) / 50.0);
      }
  }
  std::int64_t next_us() const { return INT64_MAX; }

  std::string out;
  std::array<double, 3> celsius{-20, -20, -20}, set_celsius{-50, -50, -50}, frozen_at{};
  std::array<bool, 3> relay{}, dead{}, open{}, frozen{}, stuck_on{};

 private:
  std::string line_;
  std::int64_t t_us_ = 1'000'000;
};

using HeaterRig = test::FakeRig<Heater, FakeHeaters>;

struct HeaterLab {
  FakeHeaters fake;
  Heater heater{HeaterOptions{}};
  HeaterRig rig{heater, fake};

  Result set(double tip, double window, double conduit) {
    rig.act([&](std::int64_t t, Effects& fx) { heater.set({tip, window, conduit}, t, fx); });
    REQUIRE(rig.run([&] { return !heater.busy(); }, 30));
    return rig.all<Result>().back();
  }
  void start() {
    rig.open();
    REQUIRE(rig.run([&] { return heater.safe(); }, 10));
    CHECK(set(20, 22, 20).outcome == Outcome::kDone);
    rig.run_for(120.0);
    CHECK(rig.all<Fault>().empty());
    rig.events.clear();
  }
  std::int8_t fault_of(int channel) const {
    return rig.all<Temperatures>().back().fault[std::size_t(channel)];
  }
};

}  // namespace

TEST_CASE("the heaters' driver speaks as its card says, whatever the split of the replies", "[heater]") {
  for (const std::size_t split : {0, 1, 4}) {
    Heater heater{HeaterOptions{}};
    test::play(
        heater, kHeaterTranscripts + "heater_set.txt",
        [&](const std::string&, std::int64_t t, Effects& fx) {
          heater.set({20, 22.5, -60}, t, fx);
        },
        split);
  }
}

TEST_CASE("temperatures come once a second and settle at the set points without a fault", "[heater]") {
  HeaterLab lab;
  lab.start();
  lab.rig.run_for(600.0);
  const auto all = lab.rig.all<Temperatures>();
  CHECK(all.size() >= 598);
  CHECK(all.size() <= 601);
  CHECK(lab.rig.all<Fault>().empty());
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(std::abs(all.back().celsius[c] - all.back().set_celsius[c]) < 1.5);
}

TEST_CASE("interlock 10: heater (a) fails in any way, and (b) alone goes on, and both, and the print stops",
          "[heater][I10]") {
  for (const int way : {0, 1, 2})
    for (const int first : {Heater::kTip, Heater::kWindow}) {
      const auto fail = [&](FakeHeaters& f, int channel) {
        const auto c = std::size_t(channel);
        f.frozen_at[c] = f.celsius[c];
        (way == 0 ? f.dead : way == 1 ? f.open : f.frozen)[c] = true;
      };
      HeaterLab lab;
      lab.start();
      fail(lab.fake, first);
      REQUIRE(lab.rig.run([&] { return lab.rig.faulted(kTemperature); }, 300));
      const Fault one = lab.rig.all<Fault>().back();
      INFO(one.text);
      CHECK(one.severity == Severity::kWarning);
      CHECK(one.text.find(first == Heater::kTip ? "(b) alone" : "(a) alone") != std::string::npos);
      CHECK(lab.heater.keeps_warm());
      if (way == 1) CHECK(lab.fault_of(first) == kOpenThermocouple);
      if (way == 2) CHECK(lab.fault_of(first) == kFrozenReading);
      CHECK(lab.fake.set_celsius[std::size_t(first)] == -50.0);  // not trusted any more
      fail(lab.fake, 1 - first);
      REQUIRE(lab.rig.run([&] { return !lab.heater.keeps_warm(); }, 300));
      const Fault both = lab.rig.all<Fault>().back();
      CHECK(both.severity == Severity::kStop);
      CHECK(both.text.find("neither (a) nor (b)") != std::string::npos);
    }
}

TEST_CASE("interlock 10: a dead heater is found before its channel freezes", "[heater][I10]") {
  HeaterLab lab;
  lab.start();
  lab.fake.dead[0] = true;
  REQUIRE(lab.rig.run([&] { return lab.rig.faulted(kTemperature); }, 300));
  CHECK((lab.fault_of(0) == kNoRise || lab.fault_of(0) == kTooCold));
  CHECK(lab.fake.celsius[0] > 0.0);
}

TEST_CASE("interlock 10: a heater that never warms up is found within a minute", "[heater][I10]") {
  HeaterLab lab;
  lab.rig.open();
  REQUIRE(lab.rig.run([&] { return lab.heater.safe(); }, 10));
  lab.fake.dead[2] = true;
  lab.set(20, 22, 20);
  REQUIRE(lab.rig.run([&] { return lab.rig.faulted(kTemperature); }, 65));
  CHECK((lab.fault_of(2) == kNoRise || lab.fault_of(2) == kFrozenReading));  // at rest both look the same
  CHECK(lab.rig.all<Fault>().back().severity == Severity::kWarning);
}

TEST_CASE("interlock 10: a relay that sticks is switched off as too hot and stops the print",
          "[heater][I10]") {
  HeaterLab lab;
  lab.start();
  lab.fake.stuck_on[1] = true;
  REQUIRE(lab.rig.run([&] { return lab.rig.faulted(kTemperature); }, 600));
  CHECK(lab.fault_of(1) == kTooHot);
  CHECK(lab.rig.all<Fault>().back().severity == Severity::kStop);
  CHECK(lab.fake.set_celsius[1] == -50.0);
}

TEST_CASE("one open reading is a glitch, two are an open thermocouple", "[heater][I10]") {
  HeaterWatch watch{HeaterOptions{}};
  CHECK(watch.judge(20.0, 20.0, false, 1'000'000) == kHeaterWell);
  CHECK(watch.judge(std::nan(""), 20.0, false, 2'000'000) == kHeaterWell);
  CHECK(watch.judge(20.01, 20.0, false, 3'000'000) == kHeaterWell);
  CHECK(watch.judge(std::nan(""), 20.0, false, 4'000'000) == kHeaterWell);
  CHECK(watch.judge(std::nan(""), 20.0, false, 5'000'000) == kOpenThermocouple);
  CHECK(watch.judge(20.0, 20.0, false, 6'000'000) == kOpenThermocouple);  // not trusted again
  watch.reset();
  CHECK(watch.judge(20.0, 20.0, false, 7'000'000) == kHeaterWell);
}

TEST_CASE("a still reading proves nothing while nothing heats", "[heater]") {
  HeaterWatch watch{HeaterOptions{}};
  for (int s = 1; s < 500; ++s) CHECK(watch.judge(-20.0, -50.0, false, s * 1'000'000LL) == kHeaterWell);
}

TEST_CASE("a set point above the limit is refused, and the heat stays on through stops and lost links",
          "[heater]") {
  HeaterLab lab;
  lab.start();
  CHECK(lab.set(20, 50, 20).outcome == Outcome::kRefused);
  CHECK(lab.rig.all<Result>().back().text.find("50 degC") != std::string::npos);
  CHECK(lab.set(20, std::nan(""), 20).outcome == Outcome::kRefused);
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.heater.safe_stop(t, fx); });
  lab.rig.run_for(10.0);
  CHECK(lab.fake.set_celsius == std::array<double, 3>{20, 22, 20});
  lab.fake.set_celsius = {-50, -50, -50};  // its power was off
  lab.rig.close();
  REQUIRE(lab.rig.run([&] { return lab.heater.safe(); }, 30));
  lab.rig.run_for(2.0);
  CHECK(lab.fake.set_celsius == std::array<double, 3>{20, 22, 20});
}

TEST_CASE("lost, late, cut and damaged replies falsify no temperature", "[heater]") {
  std::uint64_t seed = 71;
  HeaterLab lab;
  lab.start();
  lab.rig.line = test::lossy_line(seed, 20, 900'000);
  lab.rig.run_for(1000.0);
  const auto all = lab.rig.all<Temperatures>();
  CHECK(all.size() > 300);
  for (const Temperatures& t : all)
    for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(t.celsius[c] - t.set_celsius[c]) < 3.0);
  CHECK_FALSE(lab.rig.faulted(kTemperature));
}

TEST_CASE(
    "interlock 10: a platen's heater that fails in any way stops the print, and the other channels are free",
    "[heater][I10]") {
  for (const int way : {0, 1, 2, 3}) {
    CAPTURE(way);
    FakeHeaters fake;
    HeaterOptions options;
    options.platen_degC = 20.0;
    Heater heater{options};
    HeaterRig rig{heater, fake};
    fake.open[1] = fake.open[2] = true;  // nothing is connected there
    rig.open();
    REQUIRE(rig.run([&] { return heater.safe(); }, 10));
    const auto set = [&](double platen, double other) {
      rig.act([&](std::int64_t t, Effects& fx) { heater.set({platen, other, -50}, t, fx); });
      REQUIRE(rig.run([&] { return !heater.busy(); }, 30));
      return rig.all<Result>().back();
    };
    CHECK(set(20, 5).outcome == Outcome::kRefused);
    CHECK(set(20, -50).outcome == Outcome::kDone);
    rig.run_for(120.0);
    REQUIRE(rig.all<Fault>().empty());
    (way == 0 ? fake.dead : way == 1 ? fake.open : way == 2 ? fake.frozen : fake.stuck_on)[0] = true;
    fake.frozen_at[0] = fake.celsius[0];
    REQUIRE(rig.run([&] { return rig.faulted(kTemperature); }, 600));
    const Fault f = rig.all<Fault>().back();
    CHECK(f.severity == Severity::kStop);
    CHECK(f.text.starts_with("heater: platen: "));
    CHECK_FALSE(heater.keeps_warm());
    rig.run_for(2.0);
    CHECK(fake.set_celsius[0] == -50.0);
  }
}
