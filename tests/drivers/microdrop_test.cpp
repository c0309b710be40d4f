// The Microdrop's driver against its twin, which is written from the same card: its words, its refusals
// without an external trigger, and the end of a pass.
#include <catch2/catch.hpp>
#include <tuple>

#include "core/grid/firing_order.h"
#include "drivers/jet/microdrop.h"
#include "drivers/stage/stage.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::next;
using firn::drivers::test::WorldRig;
using plant::FaultKind;

namespace {

JetOptions with_words(const std::string& on, const std::string& off) {
  JetOptions o;
  o.dwell_v = 72.0;
  o.dwell_us = 24.0;
  o.trigger_on = on;
  o.trigger_off = off;
  return o;
}

plant::WorldConfig microdrop_world(const JetOptions& o) {
  plant::WorldConfig c = WorldRig::small_world(12, 6);
  c.jet.kind = "microdrop";
  c.jet.trigger_on = o.trigger_on;
  c.jet.trigger_off = o.trigger_off;
  return c;
}

/// Stage and Microdrop of an ink-jet lab; the words of its trigger are the twin's too.
struct MicrodropRig : test::PortRig {
  /// @param version that it tells in the place of the twin's 214
  explicit MicrodropRig(const JetOptions& o = with_words("SetTrigger(1,1)", "SetTrigger(1,0)"),
                        std::string version = "214")
      : PortRig(microdrop_world(o)), stage(WorldRig::fast_stage()), jet(o), version_(std::move(version)) {
    add("stage", stage);
    add("jet", jet);
    connect_all();
  }
  void fault(FaultKind kind, std::int64_t count = 1, std::int64_t delay_us = 0) {
    world.inject({"jet", kind, count, delay_us}, now_us);
  }
  Result arm() {
    act("jet", [&](std::int64_t t, Effects& fx) { jet.arm(72, t, fx); });
    REQUIRE(run([&] { return !jet.busy(); }, 30.0));
    return all<Result>("jet").back();
  }
  Result disarm() {
    REQUIRE(run([&] { return jet.state() == DeviceState::kArmed || jet.safe(); }, 60.0));
    act("jet", [&](std::int64_t t, Effects& fx) { jet.disarm(t, fx); });
    REQUIRE(run([&] { return !jet.busy() && jet.safe(); }, 60.0));
    return all<Result>("jet").back();
  }
  void begin_pass() {
    DropletPattern full(world.config().grid);
    full.cells.assign(full.size(), 1);
    act("stage", [&](std::int64_t t, Effects& fx) { stage.run_pass(full, 0, 1.0, 0.0, t, fx); });
  }
  std::int64_t fired() const { return world.truth().droplets_fired; }

  Stage stage;
  Microdrop jet;

 private:
  std::string to_host(std::string_view, std::string bytes) override {
    if (const std::size_t at = bytes.find("214"); at != std::string::npos) bytes.replace(at, 3, version_);
    return bytes;
  }
  std::string version_;
};

}  // namespace

TEST_CASE("a Microdrop is set up by the card's lines and read back before it is safe", "[jet][microdrop]") {
  MicrodropRig rig;
  CHECK(
      rig.written["jet"].starts_with("SetActive(1,0)\rSetTrigger(1,0)\rSetPulseVoltage(1,1,72)\r"
                                     "SetPulseLength(1,1,24)\rRefreshPulse(1)\rSetFrequency(1,2000)\r"
                                     "SetDrops(1,1)\rGetPulseVoltage(1,1)\rGetPulseLength(1,1)\r"
                                     "GetFrequency(1)\rGetDrops(1)\rGetConfig(1,3)\rGetConfig(1,6)\r"));
  CHECK(rig.jet.state() == DeviceState::kSafe);
  CHECK(rig.arm().outcome == Outcome::kReady);
  CHECK(rig.written["jet"].ends_with("SetActive(1,1)\rSetTrigger(1,1)\r"));
}

TEST_CASE("a Microdrop without a word for its trigger is never armed, and says which key lacks it",
          "[jet][microdrop][I11]") {
  MicrodropRig rig(with_words("", ""));
  const std::size_t before = rig.written["jet"].size();
  const Result r = rig.arm();
  CHECK(r.outcome == Outcome::kRefused);
  CHECK(r.code == kInstrument);
  CHECK_THAT(r.text, Catch::Contains("no external trigger") && Catch::Contains("jet.trigger_on"));
  CHECK(rig.written["jet"].size() == before);
  rig.begin_pass();
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  CHECK(rig.fired() == 0);
}

TEST_CASE("a Microdrop that is armed fires one droplet a pulse, and none after its disarming",
          "[jet][microdrop]") {
  MicrodropRig rig;
  REQUIRE(rig.arm().outcome == Outcome::kReady);
  rig.begin_pass();
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  CHECK(rig.all<Result>("stage").back().outcome == Outcome::kDone);
  CHECK(rig.fired() == 72);
  const Result r = rig.disarm();
  CHECK(r.outcome == Outcome::kDone);
  CHECK(r.counted == -1);
  rig.begin_pass();
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  CHECK(rig.fired() == 72);
  for (const auto& note : rig.record.history.devices) CHECK(note.event != plant::DeviceEvent::kJetAbused);
}

TEST_CASE("a Microdrop that lost its power or its link during a pass leaves all of it in doubt",
          "[jet][microdrop]") {
  for (const FaultKind kind : {FaultKind::kPower, FaultKind::kReboot, FaultKind::kClose}) {
    CAPTURE(int(kind));
    MicrodropRig rig;
    REQUIRE(rig.arm().outcome == Outcome::kReady);
    rig.begin_pass();
    rig.run_for(0.3);
    rig.fault(kind);
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
    const Result r = rig.disarm();
    CHECK(r.outcome == Outcome::kUnknown);
    CHECK(r.unknown_to == 72);
    CHECK(rig.disarm().outcome == Outcome::kUnknown);  // asked again
    REQUIRE(rig.arm().outcome == Outcome::kReady);
    CHECK(rig.disarm().outcome == Outcome::kDone);
  }
}

TEST_CASE("whatever becomes of its lines, a Microdrop says done only of a pass that it was armed for",
          "[jet][microdrop]") {
  std::uint64_t seed = 3;
  int done = 0, doubted = 0, never = 0;
  for (int round = 0; round < 40; ++round) {
    CAPTURE(round);
    MicrodropRig rig;
    const FaultKind kinds[] = {FaultKind::kDropReply, FaultKind::kDelayReply, FaultKind::kSplitReply,
                               FaultKind::kClose, FaultKind::kHalfOpen};
    const FaultKind kind = kinds[next(seed) % 5];
    if (next(seed) % 2) rig.fault(kind, 1, 700'000);
    const Result armed = rig.arm();
    if (armed.outcome != Outcome::kReady) {
      ++never;
      CHECK(armed.outcome == Outcome::kNone);
      CHECK(rig.fired() == 0);
      continue;
    }
    rig.begin_pass();
    rig.run_for(double(next(seed) % 400) * 1e-3);
    rig.fault(kind, 1, 700'000);
    const bool stopped = next(seed) % 3 == 0;
    if (stopped) rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 100.0));
    const Result r = rig.disarm();
    if (r.outcome == Outcome::kDone && !stopped) CHECK(rig.fired() == 72);
    const std::int64_t before = rig.fired();
    rig.begin_pass();
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 100.0));
    CHECK(rig.fired() == before);
    ++(r.outcome == Outcome::kDone ? done : doubted);
  }
  CHECK(done > 3);
  CHECK(doubted > 3);
  CHECK(never > 0);
}

namespace {

Result order(MicrodropRig& rig, std::string_view verb, const std::vector<double>& values) {
  const std::size_t before = rig.all<Result>("jet").size();
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.serve(verb, values, t, fx); });
  REQUIRE(rig.run([&] { return rig.all<Result>("jet").size() > before; }, 60.0));
  return rig.all<Result>("jet").back();
}

}  // namespace

TEST_CASE("a Microdrop fires the droplets that a person asks for, and is as a print has it afterwards",
          "[jet][microdrop][service]") {
  MicrodropRig rig(with_words("", ""));
  for (const auto& [verb, value, droplets] :
       {std::tuple{"fire", 5.0, std::size_t(5)}, {"continuous", 0.02, std::size_t(40)}}) {
    rig.record.history.shots.clear();
    CHECK(order(rig, verb, {value}).outcome == Outcome::kDone);
    CHECK(rig.jet.safe());
    CHECK(rig.record.history.shots.size() == droplets);
    CHECK(rig.written["jet"].ends_with("SetActive(1,0)\rSetDrops(1,1)\r"));
  }
}

TEST_CASE("a stop of a Microdrop that fires for a person makes it inactive first of all",
          "[jet][microdrop][service]") {
  MicrodropRig rig(with_words("", ""));
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.serve("continuous", std::vector{10.0}, t, fx); });
  rig.run_for(1.0);
  const std::size_t before = rig.written["jet"].size();
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
  CHECK(rig.written["jet"].substr(before).starts_with("SetActive(1,0)\r"));
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 5.0));
  CHECK(rig.all<Result>("jet").back().outcome == Outcome::kFailed);
}

TEST_CASE("a Microdrop tells who it is, takes a pulse and a strobe, and refuses what its card lacks",
          "[jet][microdrop][service]") {
  MicrodropRig rig(with_words("", ""));
  CHECK(order(rig, "serial", {}).text == "Microdrop MD-E hardware 7, software 214");
  CHECK_THAT(MicrodropRig(with_words("", ""), "V2.14").jet.identity(), Catch::Contains("V2.14"));
  CHECK(order(rig, "strobe", {1, 250}).outcome == Outcome::kDone);
  CHECK(order(rig, "waveform", {80, 0, 30, 0}).outcome == Outcome::kDone);
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 5.0));  // read back with the new pulse
  const std::string sent = rig.written["jet"];
  const std::tuple<const char*, std::vector<double>, const char*> refused[] = {
      {"strobe", {2, 250}, "(0, 1]"},
      {"strobe", {1, 70000}, "65535"},
      {"waveform", {80, -20, 30, 9}, "one pulse"},
      {"waveform", {500, 0, 30, 0}, "100"},
      {"fire", {1e6}, "2000"},
      {"continuous", {60}, "32.7"}};
  for (const auto& [verb, values, why] : refused) {
    const Result r = order(rig, verb, values);
    CHECK(r.outcome == Outcome::kRefused);
    CHECK_THAT(r.text, Catch::Contains(why));
  }
  CHECK(rig.written["jet"] == sent);
}

// Source: DropletDynamics' InkJetDroplet, which strips a character of some numeric answers and of others not,
// and reads some as decimal numbers.
TEST_CASE("a Microdrop's number is read with and without a character before it or a point behind it",
          "[microdrop][conformance]") {
  const MicrodropDialect dialect;
  const Request asked = dialect.probe();
  const auto is_number = [&](std::string_view line) {
    return dialect.frame(std::as_bytes(std::span(line)), &asked).kind == Frame::Kind::kReply;
  };
  for (const std::string_view good : {"x1000\r", "1000\r", "x72.0\r", "72.\r", ">0\r"})
    CHECK(is_number(good));
  for (const std::string_view bad :
       {"\r", "x\r", "xx10\r", "72.5\r", "x72.05\r", "-95\r", "x-95\r", "10 0\r", ".\r"})
    CHECK_FALSE(is_number(bad));
}
