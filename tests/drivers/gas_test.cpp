// The gas driver against its twin, and its codec against lines of the vendor's documents and of two public
// programs (docs/devices/gas.md).
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/gas/gas.h"
#include "plant/twins/gas.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/fake_rig.h"
#include "tests/drivers/lossy_line.h"

using namespace firn;
using namespace firn::drivers;
using Catch::Contains;

namespace {

struct NoWires : plant::Wires {
  void pulse(int, std::int64_t, const double[3], const double[3]) override {}
  void softtrigger(std::int64_t, plant::Port, int) override {}
  void lamp(std::int64_t, plant::LampEvent, double) override {}
  void link_closed(std::int64_t, plant::Port) override {}
  void note(std::int64_t, plant::Port, plant::DeviceEvent, std::int64_t) override {}
};

/// The twin as FakeRig has instruments.
struct GasLine {
  explicit GasLine(plant::GasParams params = {}) : twin(plant::Port::kHeater, params, wires) {
    twin.link().connect(0);
  }
  void take(std::string_view bytes, std::int64_t now_us) {
    heard += bytes;
    twin.link().arrive(std::as_bytes(std::span(bytes.data(), bytes.size())), now_us);
    advance(now_us);
  }
  void advance(std::int64_t now_us) {
    while (twin.next_inner_us() <= now_us) twin.step();
    while (twin.link().next_send_us() <= now_us) {
      std::string sent(twin.link().pop_send().bytes);
      if (const std::size_t at = sent.find(" N2");
          at != std::string::npos && sent[0] == 'A' && damaged_names > 0) {
        --damaged_names;
        sent[at + 2] = '3';
      }
      out += rewritten ? rewritten(sent) : sent;
    }
  }
  std::int64_t next_us() const {
    return twin.next_visible_us() < twin.next_inner_us() ? twin.next_visible_us() : twin.next_inner_us();
  }

  NoWires wires;
  plant::GasTwin twin;
  std::string out, heard;
  std::function<std::string(const std::string&)> rewritten;  ///< a reply as another firmware or line sends it
  int damaged_names = 0;  ///< of the gas, in the atomizer's next data frames
};

struct FakeGasRig {
  explicit FakeGasRig(plant::GasParams params = {}, GasOptions options = {}, int damaged_names = 0,
                      decltype(GasLine::rewritten) rewritten = {})
      : line(std::move(params)), gas(std::move(options)), rig(gas, line) {
    line.damaged_names = damaged_names;
    line.rewritten = std::move(rewritten);
    rig.lines = false;
    rig.open();
    rig.run([&] { return gas.safe(); }, 10.0);
  }
  Result set(double atomizer, double sheath, double within_s = 60.0) {
    const std::size_t before = rig.all<Result>().size();
    rig.act([&](std::int64_t t, Effects& fx) { gas.set(atomizer, sheath, t, fx); });
    REQUIRE(rig.run([&] { return rig.all<Result>().size() > before; }, within_s));
    return rig.all<Result>().back();
  }
  double sccm(int n) { return line.twin.sccm(n, rig.now_us); }
  void trip(std::int64_t code) { line.twin.trip(rig.now_us, code); }
  /// The first fault that stops a print; without text: none.
  Fault stop() const {
    for (const auto& f : rig.all<Fault>())
      if (f.severity == Severity::kStop) return f;
    return {};
  }
  std::string stopped() const { return stop().text; }

  GasLine line;
  Gas gas;
  drivers::test::FakeRig<Gas, GasLine> rig;
};

/// The most digits of a number in a text, zeros before the first one left out.
int longest_number(const std::string& text) {
  int most = 0, digits = 0;
  for (const char c : text + ' ') {
    if (c >= (digits == 0 ? '1' : '0') && c <= '9')
      ++digits;
    else if (c != '.' && c != '0')
      digits = 0;
    most = std::max(most, digits);
  }
  return most;
}

}  // namespace

TEST_CASE("a data frame is read as the vendor's documents have it, with its codes and its total", "[gas]") {
  const auto r = alicat::parse_reading("A +014.62 +021.89 +000.00 -000.01 +078.95     N2");
  REQUIRE(r);
  CHECK(r->unit == 'A');
  CHECK(r->pressure == 14.62);
  CHECK(r->temperature_degC == 21.89);
  CHECK(r->mass_flow == -0.01);
  CHECK(r->set_point == 78.95);
  CHECK(r->resolution == Approx(0.01));
  CHECK(r->gas == "N2");
  CHECK(r->codes == 0);
  const auto more = alicat::parse_reading("B +014.70 +025.0 +1.0 +1.000 +50.000 +0021513.0 Air MOV LCK XYZ");
  REQUIRE(more);
  CHECK(more->gas == "Air");
  CHECK(more->codes == (alicat::kMassOver | alicat::kLocked));
  CHECK(alicat::names_of(more->codes) == "LCK MOV");
  for (const char* none :
       {"", "A", "?", "A ?", "A +014.70 +025.00 +00.000 +00.000 N2", "a +1.0 +1.0 +1.0 +1.0 +1.0 N2",
        "A +1.0 +1.0 +1.0 +1.0 +1.0", "A 14.70 +025.00 +00.000 +00.000 +00.000 N2",
        "A +1.0 +1.0 +1.0 +1.0 +1.0 +1.0 +1.0 +1.0 N2", "A +1. +1.0 +1.2.3 +1.0 +1.0 N2",
        "A +1.0 +1.0 +1.0 +1.0 +1.0e1 N2", "A +1.0 +1.0 +1.0 +1.0 +1,0 N2",
        "A +1.0 +1.0 +1.0 +1.0SCCM +1.0 N2"})
    CHECK_FALSE(alicat::parse_reading(none));
}

TEST_CASE("another unit's line, a late data frame and a line that never ends answer nothing", "[gas]") {
  const alicat::AlicatDialect dialect;
  const GasDialect texts;
  const auto kind = [&](const Request& asked, std::string_view line) {
    return dialect.frame(std::as_bytes(std::span(line.data(), line.size())), &asked).kind;
  };
  const Request poll = alicat::poll_request({'A', false}, 0),
                version = alicat::version_request({'A', false}, texts, 0);
  constexpr std::string_view data = "A +014.62 +021.89 +000.00 +000.00 +078.95     N2\r";
  CHECK(kind(poll, data) == Frame::Kind::kReply);
  CHECK(kind(poll, data.substr(0, data.size() - 1)) == Frame::Kind::kIncomplete);
  CHECK(kind(poll, "B +014.62 +021.89 +000.00 +000.00 +078.95     N2\r") == Frame::Kind::kCorrupt);
  CHECK(kind(version, data) == Frame::Kind::kCorrupt);
  CHECK(kind(version, "A   8v17.0-R23 Nov 27 2019,15:28:45\r") == Frame::Kind::kReply);
  CHECK(kind(poll, "?\r") == Frame::Kind::kReply);
  CHECK(kind(poll, std::string(200, '+')) == Frame::Kind::kCorrupt);
  CHECK(alicat::set_request({'B', true}, 12.5, texts, 0).text() == "B$$S12.500\r");
}

TEST_CASE("the sheath flows before the atomizer's gas and ends after it", "[gas][I16]") {
  FakeGasRig rig;
  CHECK(rig.gas.identity() == "Alicat A firmware 10v20.0-R24, B firmware 10v20.0-R24");
  const auto set = [&](double atomizer, double sheath) {  // no ink without a sheath meanwhile
    const std::size_t before = rig.rig.all<Result>().size();
    rig.rig.act([&](std::int64_t t, Effects& fx) { rig.gas.set(atomizer, sheath, t, fx); });
    bool bare = false;
    REQUIRE(rig.rig.run(
        [&] {
          bare = bare || (rig.sccm(0) > 1.0 && rig.sccm(1) < 30.0);
          return rig.rig.all<Result>().size() > before;
        },
        60.0));
    CHECK_FALSE(bare);
    return rig.rig.all<Result>().back().outcome;
  };
  CHECK(set(20.0, 40.0) == Outcome::kDone);
  CHECK(std::abs(rig.sccm(0) - 20.0) < 1.0);
  CHECK(std::abs(rig.sccm(1) - 40.0) < 2.0);
  CHECK(rig.gas.state() == DeviceState::kActive);
  rig.line.heard.clear();
  CHECK(set(0.0, 0.0) == Outcome::kDone);
  CHECK(rig.line.heard.find("AS0") < rig.line.heard.find("BS0"));
  CHECK(rig.gas.safe());
}

TEST_CASE("a stop ends the atomizer's gas first of all and leaves the sheath's", "[gas]") {
  FakeGasRig rig;
  REQUIRE(rig.set(20.0, 40.0).outcome == Outcome::kDone);
  rig.line.heard.clear();
  rig.rig.act([&](std::int64_t t, Effects& fx) { rig.gas.safe_stop(t, fx); });
  CHECK(rig.line.heard.starts_with("AS0.000\r"));
  REQUIRE(rig.rig.run([&] { return rig.gas.safe(); }, 1.0));
  rig.rig.run_for(3.0);
  CHECK(rig.sccm(0) < 0.1);
  CHECK(std::abs(rig.sccm(1) - 40.0) < 1.0);
}

TEST_CASE("set points beyond the lab's limits, and ink without a sheath, are refused before a byte is sent",
          "[gas][I16]") {
  FakeGasRig rig;
  for (const auto& [atomizer, sheath, why] : {std::tuple{-1.0, 40.0, "[0, 100]"},
                                              {101.0, 40.0, "[0, 100]"},
                                              {20.0, 501.0, "[0, 500]"},
                                              {20.0, 0.0, "without a sheath"},
                                              {std::nan(""), 40.0, "outside"}}) {
    rig.line.heard.clear();
    const Result r = rig.set(atomizer, sheath);
    CHECK(r.outcome == Outcome::kRefused);
    CHECK_THAT(r.text, Contains(why));
    CHECK(rig.line.heard.find('S') == std::string::npos);
  }
}

TEST_CASE("a sheath that is lost ends the ink and stops the print by its name", "[gas][I16]") {
  FakeGasRig rig;
  REQUIRE(rig.set(20.0, 40.0).outcome == Outcome::kDone);
  rig.trip(2);
  REQUIRE(rig.rig.run([&] { return !rig.stopped().empty(); }, 10.0));
  CHECK_THAT(rig.stopped(), Contains("sheath") && Contains("of 40 sccm"));
  CHECK(rig.stop().figure.value.value_or(1.0) < GasOptions().lost_share);
  CHECK(rig.stop().figure.limit == GasOptions().lost_share);
  CHECK(rig.stop().figure.key == "gas.lost_share");
  CHECK(longest_number(rig.stopped()) <= 4);
  CHECK(rig.gas.flows().fault[kSheath] == GasFault::kFlowLost);
  rig.rig.run_for(3.0);
  CHECK(rig.sccm(0) < 0.1);
  rig.trip(0);
  CHECK(rig.set(20.0, 40.0).outcome == Outcome::kDone);
}

TEST_CASE("a nozzle that clogs is seen by the pressure behind it", "[gas][I16]") {
  FakeGasRig rig;
  REQUIRE(rig.set(20.0, 40.0).outcome == Outcome::kDone);
  const double clean_kpa = rig.gas.flows().kpa[kSheath];
  CHECK(clean_kpa == Approx(rig.line.twin.nozzle_kpa(rig.rig.now_us)).margin(0.1));
  rig.trip(3);
  REQUIRE(rig.rig.run([&] { return !rig.stopped().empty(); }, 30.0));
  CHECK_THAT(rig.stopped(), Contains(" kPa behind the nozzle, gas.most_pressure_kpa = 120: it clogs"));
  CHECK(rig.stop().figure.value.value_or(0.0) > 120.0);
  CHECK(rig.stop().figure.limit == 120.0);
  CHECK(rig.stop().figure.unit == "kPa");
  CHECK(rig.stop().figure.key == "gas.most_pressure_kpa");
  CHECK(longest_number(rig.stopped()) <= 4);
  rig.rig.run_for(3.0);
  CHECK(rig.sccm(0) < 0.1);
}

TEST_CASE("a controller that keeps its set point to itself, or whose valve is held, is no success",
          "[gas][I16]") {
  FakeGasRig analog;
  analog.trip(4);
  const Result r = analog.set(20.0, 40.0);
  CHECK(r.outcome == Outcome::kFailed);
  CHECK_THAT(r.text, Contains("told 40 sccm its set point is 0 sccm"));
  FakeGasRig held;
  REQUIRE(held.set(20.0, 40.0).outcome == Outcome::kDone);
  held.trip(5);
  REQUIRE(held.rig.run([&] { return !held.stopped().empty(); }, 5.0));
  CHECK_THAT(held.stopped(), Contains("atomizer: HLD"));
  GasOptions wide;
  wide.sheath_max_sccm = 900.0;
  FakeGasRig over({}, wide);
  CHECK_THAT(over.set(20.0, 800.0).text, Contains("it refuses 'BS800.000'"));
}

TEST_CASE("a unit that says nothing, has another id or another gas is named", "[gas]") {
  plant::GasParams other;
  other.units = "AC";
  FakeGasRig wrong(other);
  CHECK_FALSE(wrong.gas.safe());
  const auto faults = wrong.rig.all<Fault>();
  REQUIRE_FALSE(faults.empty());
  CHECK_THAT(faults[0].text, Contains("sheath: unit B gives no good reply to 'BVE'"));
  plant::GasParams argon;
  argon.gas = "Ar";
  FakeGasRig gas(argon);
  CHECK(gas.gas.state() == DeviceState::kFault);
  CHECK_THAT(gas.stopped(), Contains("is set to Ar"));
  plant::GasParams old;
  old.gp_firmware = true;
  FakeGasRig gp(old);
  REQUIRE(gp.gas.safe());
  CHECK(gp.set(20.0, 40.0).outcome == Outcome::kDone);
  CHECK_THAT(gp.line.heard, Contains("A$$S20.000\r"));
  FakeGasRig mute;
  REQUIRE(mute.set(20.0, 40.0).outcome == Outcome::kDone);
  mute.trip(6);
  REQUIRE(mute.rig.run([&] { return !mute.stopped().empty(); }, 20.0));
  CHECK_THAT(mute.stopped(), Contains("link lost"));
}

TEST_CASE("the gas flows with set points without a sign, a total, lines of CR LF and an echo", "[gas]") {
  const auto unsigned_set_point = [](const std::string& said) {
    const std::size_t at = said.rfind(" +");
    return at == std::string::npos ? said : said.substr(0, at + 1) + said.substr(at + 2);
  };
  const auto with_total = [](const std::string& said) {
    const std::size_t at = said.find("     N2");
    return at == std::string::npos ? said : said.substr(0, at) + " +0021513.0" + said.substr(at);
  };
  const auto cr_lf = [](const std::string& said) { return said + "\n"; };
  std::vector<decltype(GasLine::rewritten)> customs{unsigned_set_point, with_total, cr_lf};
  for (const auto& custom : customs) {
    FakeGasRig rig({}, {}, 0, custom);
    REQUIRE(rig.gas.safe());
    rig.rig.split = 1;
    CHECK(rig.set(20.0, 40.0).outcome == Outcome::kDone);
    CHECK(rig.rig.all<Fault>().empty());
  }
}

TEST_CASE("a unit that says nothing to VE and answers a poll has the oldest firmware", "[gas]") {
  plant::GasParams old;
  old.gp_firmware = true;
  FakeGasRig rig(old, {}, 0, [](const std::string& said) {
    return said.find("GP07R100") == std::string::npos ? said : std::string();
  });
  REQUIRE(rig.gas.safe());
  CHECK_THAT(rig.gas.identity(), Contains("A firmware GP, which does not tell its version"));
  CHECK(rig.set(20.0, 40.0).outcome == Outcome::kDone);
  CHECK_THAT(rig.line.heard, Contains("A$$S20.000\r"));
}

TEST_CASE("a unit whose lines are not understood is named with the last of them", "[gas]") {
  FakeGasRig meter({}, {}, 0, [](const std::string& said) {  // a meter's poll has no set point
    const std::size_t at = said.find("     N2");
    return at == std::string::npos ? said : said.substr(0, at - 8) + said.substr(at);
  });
  CHECK_FALSE(meter.gas.safe());
  CHECK_THAT(meter.gas.last_not_understood(), Catch::StartsWith("'A +") && Catch::EndsWith(" N2'"));
  const auto states = meter.rig.all<StateChange>();
  CHECK(std::ranges::any_of(states, [](const StateChange& s) {
    return s.text.find("no answer; not understood: 'A +") != std::string::npos;
  }));
}

TEST_CASE("a gas's name damaged on the line is asked for again, and twice more at most", "[gas]") {
  for (const int damaged : {1, 2}) {
    FakeGasRig asked({}, {}, damaged);
    CHECK(asked.gas.safe());
    CHECK(asked.stopped().empty());
  }
  FakeGasRig believed({}, {}, 3);
  CHECK(believed.gas.state() == DeviceState::kFault);
  CHECK_THAT(believed.stopped(), Contains("atomizer is set to N3"));
}

TEST_CASE("a person reads model and serial number of both controllers", "[gas][service]") {
  FakeGasRig rig;
  rig.rig.act([&](std::int64_t t, Effects& fx) { rig.gas.serve("serial", {}, t, fx); });
  REQUIRE(rig.rig.run([&] { return !rig.rig.all<Result>().empty(); }, 5.0));
  CHECK(rig.rig.all<Result>()[0].text == "MC-SCCM-D 52164A, MC-SCCM-D 52164B");
}

TEST_CASE("whatever becomes of its line, the gas says done only of flows that are there", "[gas]") {
  std::uint64_t seed = 31;
  int done = 0;
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    FakeGasRig rig;
    rig.rig.line = [&](std::string& said) -> std::int64_t {
      const std::uint64_t n = drivers::test::next(seed) % 12;
      if (n == 0) said.clear();
      if (n == 1 && !said.empty()) said[said.size() / 2] = char(said[said.size() / 2] ^ 4);
      return n == 2 ? 900'000 : 0;
    };
    rig.rig.split = drivers::test::next(seed) % 5;
    for (int n = 0; n < 6; ++n) {
      if (!rig.rig.run([&] { return rig.gas.safe() || rig.gas.state() == DeviceState::kActive; }, 60.0))
        break;
      const double atomizer = double(drivers::test::next(seed) % 2) * 20.0;
      const double sheath = 30.0 + double(drivers::test::next(seed) % 20);
      const Result r = rig.set(atomizer, sheath, 200.0);
      if (r.outcome != Outcome::kDone) continue;
      ++done;
      REQUIRE(std::abs(rig.sccm(0) - atomizer) < 0.06 * atomizer + 0.3);
      REQUIRE(std::abs(rig.sccm(1) - sheath) < 0.06 * sheath + 1.1);
    }
  }
  CHECK(done > 60);
}
