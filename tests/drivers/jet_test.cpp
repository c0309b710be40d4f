#include <catch2/catch.hpp>

#include "drivers/jet/jet.h"
#include "tests/drivers/bench.h"

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

TEST_CASE("JetDrive frames equal the vectors of the card", "[jet]") {
  using namespace jetdrive;
  const std::uint8_t external[] = {1}, hz[] = {0x03, 0xE8};
  CHECK(bytes_of(frame(Command::kReset, {}, Repeat::kSetup)) == "53 02 01 03");
  CHECK(bytes_of(frame(Command::kSource, external, Repeat::kNever)) == "53 03 08 01 0C");
  CHECK(bytes_of(frame(Command::kFullFrequency, hz, Repeat::kSetup)) == "53 04 12 03 E8 01");
  CHECK(bytes_of(pulse(waveform_of(JetConfig{}))) ==
        "53 15 06 00 00 00 C8 00 01 90 00 00 00 14 FF EC 00 1E 00 1E 00 1E CD");
}
