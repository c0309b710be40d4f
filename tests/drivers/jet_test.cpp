#include <catch2/catch.hpp>

#include "drivers/jet/jet.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/world_rig.h"

using namespace firn::drivers;
using firn::drivers::test::Bench;

namespace {

const std::string kJetTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

void jet_command(Jet& jet, const std::string& text, std::int64_t now_us, Effects& fx) {
  if (text == "arm")
    jet.arm(12, now_us, fx);
  else if (text == "disarm")
    jet.disarm(now_us, fx);
  else
    FAIL("no command " << text);
}

std::string bytes_of(const Request& r) { return test::hex(r.text()); }

}  // namespace

TEST_CASE("the jet speaks as the JetDrive card says, whatever the split of the replies", "[jet]") {
  for (const std::size_t split : {0, 1, 2, 3}) {
    JetOptions options;
    options.max_rate_hz = 1000;
    Jet jet(options);
    test::play(
        jet, kJetTranscripts + "jet_start_arm.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) { jet_command(jet, c, t, fx); }, split);
  }
}

TEST_CASE("the waveform of the wanted size is sent before the jet is armed, and not again while it is held",
          "[jet]") {
  firn::plant::WorldConfig world = test::WorldRig::small_world(4, 4);
  world.jet.volume_by_pulse = true;
  world.nozzle.drift = false;
  world.droplet.size_scatter = world.droplet.satellite_probability = 0.0;
  test::WorldRig rig(world);
  rig.start();
  const std::string pulse = "S\x15\x06";
  const firn::DropletPattern full(rig.world.config().grid, 1);
  int sent = rig.sent("jet", pulse);
  bool held = false;
  for (const bool small : {false, true, true, false, false, true}) {
    rig.act("jet", [&](std::int64_t t, Effects& fx) {
      small ? rig.jet.arm_small(16, t, fx) : rig.jet.arm(16, t, fx);
    });
    REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 30.0));
    CHECK(rig.results("jet").back().outcome == firn::Outcome::kReady);
    CHECK(rig.sent("jet", pulse) == (sent += small != held));
    held = small;
    rig.record.history.shots.clear();
    rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(full, 0, 1.0, 50.0, t, fx); });
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
    REQUIRE(rig.record.history.shots.size() == 16);
    for (const auto& shot : rig.record.history.shots)  // 14 V of 20 V, with a threshold of 8 V
      CHECK(shot.volume_mm3 == Approx(world.droplet.volume_mm3 * (small ? 0.5 : 1.0)));
    rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.disarm(t, fx); });
    REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 30.0));
  }
}

TEST_CASE("small droplets beyond the head's volts, or of a jet with one size, are refused by name", "[jet]") {
  JetOptions weak;
  weak.dialect.max_abs_v = 20;
  weak.small_dwell_v = 21.0;
  CHECK_THAT(small_refusal(weak), Catch::Contains("21 V is beyond +-20 V"));
  JetOptions microdrop;
  microdrop.kind = JetKind::kMicrodrop;
  CHECK_THAT(small_refusal(microdrop), Catch::Contains("one size of droplet"));
  CHECK(small_refusal(JetOptions{}).empty());
}

TEST_CASE("JetDrive frames equal the vectors of the card", "[jet]") {
  using namespace jetdrive;
  const std::uint8_t external[] = {1}, hz[] = {0x03, 0xE8};
  CHECK(bytes_of(frame(Command::kReset, {}, Repeat::kSetup)) == "53 02 01 03");
  CHECK(bytes_of(frame(Command::kSource, external, Repeat::kNever)) == "53 03 08 01 0C");
  CHECK(bytes_of(frame(Command::kFullFrequency, hz, Repeat::kSetup)) == "53 04 12 03 E8 01");
  CHECK(bytes_of(pulse(waveform_of(JetConfig{}))) ==
        "53 15 06 00 00 00 C8 00 01 90 00 00 00 14 FF EC 00 1E 00 1E 00 1E CD");
}

// Source: MicroFab's own program of 1997 to 2003, which tells the two generations apart by this answer.
TEST_CASE(
    "the boot monitors of both JetDrive generations are passed, whatever stands behind the name of the later",
    "[jet][conformance]") {
  const jetdrive::JetDriveDialect dialect;
  const auto asked = [](char c, jetdrive::Format format) {
    Request r;
    r.append(std::string_view(&c, 1));
    r.format = format;
    return r;
  };
  const Request stop = asked('Q', jetdrive::kPrompt), start = asked('X', jetdrive::kEcho);
  const auto heard = [&](std::string_view text, const Request& r) {
    return dialect.frame(std::as_bytes(std::span(text)), &r);
  };
  const std::string_view earlier = "Q?Invalid command or format?      >";
  CHECK(heard(earlier, stop).kind == Frame::Kind::kReply);
  CHECK(heard(earlier, stop).size == earlier.size());
  CHECK(heard(earlier.substr(0, 20), stop).kind == Frame::Kind::kIncomplete);
  const std::string_view later = "Q MFJET32", tail = " Ver. 6.02\r\n";
  CHECK(heard(later, stop).kind == Frame::Kind::kReply);
  CHECK(heard(later, stop).size == later.size());
  for (const std::string& more : {std::string(), std::string(tail)}) {
    CHECK(heard(more + "X", start).kind == Frame::Kind::kReply);
    CHECK(heard(more + "X", start).size == more.size() + 1);
  }
  CHECK(heard(tail, start).kind == Frame::Kind::kIncomplete);
  CHECK(heard(std::string(300, '.'), start).kind == Frame::Kind::kCorrupt);
}
