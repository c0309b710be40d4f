#include <catch2/catch.hpp>

#include "drivers/lamp/lamp.h"
#include "tests/drivers/bench.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::Bench;

namespace {

const std::string kLampTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

void lamp_command(Lamp& lamp, const std::string& text, std::int64_t now_us, Effects& fx) {
  double s = 0.0;
  int iris = 0;
  if (std::sscanf(text.c_str(), "expose %lf %d", &s, &iris) == 2)
    lamp.expose(s, iris, now_us, fx);
  else if (text == "release")
    lamp.release(now_us, fx);
  else
    FAIL("no command " << text);
}

// The lamp without its status bits, whose questions lamp_status_test.cpp tests.
LampOptions without_bits() {
  LampOptions c;
  c.status_bits = firn::OnOff::kOff;
  return c;
}

// A lamp that answers everything well until told otherwise.
void answer(Bench& bench) {
  for (std::string line; !(line = bench.take_line()).empty();) {
    const std::string text = line.substr(0, line.size() - 3);
    bench.feed(omnicure::frame(text == "CONN"  ? "READY"
                               : text == "GTM" ? "5"
                               : text == "VEB" ? "10"
                               : text == "GUS" ? "0"
                                               : "Received"));
  }
}

void run_until(Bench& bench, std::int64_t until_us) {
  answer(bench);
  while (bench.wake_us() != 0 && bench.wake_us() <= until_us) {
    bench.advance_to_wake();
    answer(bench);
  }
  bench.now_us = until_us;
}

}  // namespace

TEST_CASE("the lamp speaks as the OmniCure card says, whatever the split of the replies", "[lamp]") {
  for (const std::size_t split : {0, 1, 2, 3}) {
    Lamp lamp(LampOptions{});
    test::play(
        lamp, kLampTranscripts + "omni_expose.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) { lamp_command(lamp, c, t, fx); }, split);
  }
}

TEST_CASE("OmniCure CRCs equal the vectors of the card", "[lamp]") {
  for (const char* line :
       {"CONN18", "READY0A", "OPN40", "CLS3A", "DCONE1", "ReceivedBF", "CLOSED42", "Err67"}) {
    const std::string text(line);
    CHECK(omnicure::frame(text.substr(0, text.size() - 2)) == text + "\r");
  }
}

TEST_CASE("no flipped bit of a lamp reply is taken for a reply", "[lamp]") {
  const omnicure::OmnicureDialect dialect;
  for (const auto& [reply, format] :
       {std::pair<const char*, omnicure::Format>{"Received", omnicure::kReceived},
        {"READY", omnicure::kReady},
        {"20", omnicure::kAny},
        {"CLOSED", omnicure::kClosed},
        {"Err", omnicure::kReceived}}) {
    const Request asked = omnicure::request("GTM", format, Repeat::kRead, 0);
    const std::string good = omnicure::frame(reply);
    REQUIRE(dialect.frame(std::as_bytes(std::span(good.data(), good.size())), &asked).kind ==
            Frame::Kind::kReply);
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
      std::string bad = good;
      bad[bit / 8] = char(bad[bit / 8] ^ 1 << bit % 8);
      CHECK(dialect.frame(std::as_bytes(std::span(bad.data(), bad.size())), &asked).kind !=
            Frame::Kind::kReply);
    }
  }
}

TEST_CASE("an exposure outside its limits is refused and nothing is sent", "[lamp]") {
  Lamp lamp(without_bits());
  Bench bench(lamp);
  bench.open();
  run_until(bench, 2'000'000);
  REQUIRE(lamp.state() == DeviceState::kSafe);
  for (const auto& [s, iris] :
       {std::pair<double, int>{0.0, 50}, {-1.0, 50}, {20.1, 50}, {std::nan(""), 50}, {1.0, 0}, {1.0, 101}}) {
    bench.command([&, s = s, iris = iris](std::int64_t t, Effects& fx) { lamp.expose(s, iris, t, fx); });
    CHECK(bench.all<Result>().back().outcome == Outcome::kRefused);
  }
  CHECK(bench.tx.empty());
}

TEST_CASE("the shutter is told to close at a stop, at once, whatever is awaited", "[lamp]") {
  for (int at = 0; at < 12; ++at) {  // after `at` answered lines of an exposure
    Lamp lamp(without_bits());
    Bench bench(lamp);
    bench.open();
    run_until(bench, 2'000'000);
    bench.command([&](std::int64_t t, Effects& fx) { lamp.expose(0.5, 80, t, fx); });
    for (int n = 0; n < at; ++n) {
      if (bench.tx.empty() && bench.wake_us() < bench.now_us + 900'000) bench.advance_to_wake();
      const std::string line = bench.take_line();
      if (!line.empty()) bench.feed(omnicure::frame(line.starts_with("GTM") ? "5" : "Received"));
    }
    const std::string before = bench.take();
    bench.safe_stop();
    const std::string sent = bench.take();
    const bool closing_already = before.starts_with("CLS");
    CHECK((closing_already || sent.starts_with("CLS3A\r")));
    if (!before.empty()) bench.feed(omnicure::frame("Received"));
    bench.tx = sent + bench.tx;
    run_until(bench, bench.now_us + 3'000'000);
    CHECK(lamp.safe());
    CHECK(!lamp.busy());
    CHECK(!lamp.may_be_open());
  }
}

TEST_CASE("a lamp that falls silent with the shutter open is told to close, and told again after it is back",
          "[lamp][I9]") {
  Lamp lamp(without_bits());
  Bench bench(lamp);
  bench.open();
  run_until(bench, 2'000'000);
  bench.command([&](std::int64_t t, Effects& fx) { lamp.expose(0.5, 80, t, fx); });
  while (!lamp.may_be_open()) answer(bench);
  bench.tx.clear();
  bench.advance_us(8'000'000);  // no answer to CLS, none to the probe
  CHECK(bench.take().find("CLS3A\r") != std::string::npos);
  CHECK(bench.reopens > 0);
  CHECK(lamp.state() == DeviceState::kDisconnected);
  CHECK(lamp.busy());
  bench.close();
  bench.open();
  run_until(bench, bench.now_us + 3'000'000);
  CHECK(lamp.safe());
  CHECK(!lamp.may_be_open());
  REQUIRE(bench.all<Result>().size() == 1);
  CHECK(bench.all<Result>()[0].outcome == Outcome::kUnknown);
}

TEST_CASE(
    "a lamp that falls silent between exposures is a stop within ten seconds, told once for each silence",
    "[lamp][I2]") {
  Lamp lamp(without_bits());
  Bench bench(lamp);
  bench.open();
  run_until(bench, 2'000'000);
  REQUIRE(lamp.safe());
  run_until(bench, bench.now_us + 60'000'000);  // it answers all the time
  const auto stops = [&] {
    int n = 0;
    for (const Fault& f : bench.all<Fault>()) n += f.severity == firn::Severity::kStop && f.code == kLinkLost;
    return n;
  };
  CHECK(stops() == 0);
  bench.advance_us(10'000'000);
  CHECK(stops() == 1);
  bench.advance_us(30'000'000);
  CHECK(stops() == 1);
}

TEST_CASE(
    "a lamp whose port is closed between exposures and does not come back is a stop within eleven seconds",
    "[lamp][I2]") {
  Lamp lamp(without_bits());
  Bench bench(lamp);
  bench.open();
  run_until(bench, 2'000'000);
  REQUIRE(lamp.safe());
  bench.close();
  bench.advance_us(11'000'000);
  int stops = 0;
  for (const Fault& f : bench.all<Fault>())
    stops += f.severity == firn::Severity::kStop && f.code == kLinkLost;
  CHECK(stops == 1);
}
