#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/laser_profiler/laser_profiler.h"
#include "tests/drivers/bench.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::Bench;
using firn::drivers::test::unhex;

namespace {

const std::string kProfilerTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

void put(std::string& s, std::size_t at, std::uint32_t v, int bytes = 4) {
  for (int n = 0; n < bytes; ++n) s[at + std::size_t(n)] = char(v >> 8 * n);
}

// A reply as docs/devices/laser_profiler.md describes it, written here without the codec.
std::string profile_reply(std::uint32_t trigger, std::int32_t encoder,
                          const std::vector<std::int32_t>& samples, std::uint32_t unit = 10) {
  const std::size_t packed = (samples.size() * 20 + 7) / 8;
  std::string s(28 + 60 + packed + 4, '\0');
  put(s, 0, std::uint32_t(s.size() - 4));
  put(s, 4, 0x00F00001);
  put(s, 12, std::uint32_t(s.size() - 16));
  s[16] = 0x42;
  s[28 + 12] = 1;
  put(s, 28 + 24, std::uint32_t(samples.size()), 2);
  put(s, 28 + 26, unit, 2);
  put(s, 28 + 28, std::uint32_t(-500'000));
  put(s, 28 + 32, 2'000);
  put(s, 28 + 40, trigger);
  put(s, 28 + 44, std::uint32_t(encoder));
  std::uint64_t window = 0;
  int bits = 0;
  std::size_t at = 28 + 60;
  for (const std::int32_t v : samples) {
    window |= std::uint64_t(std::uint32_t(v) & 0xFFFFFu) << bits;
    for (bits += 20; bits >= 8; bits -= 8, window >>= 8) s[at++] = char(window);
  }
  if (bits > 0) s[at] = char(window);
  return s;
}

const std::string kProgramDone =
    unhex("18 00 00 00 01 00 F0 00 00 00 00 00 0C 00 00 00 39 00 00 00 00 00 00 00 00 00 00 00");
const std::string kNothingYet =
    unhex("30 00 00 00 01 00 F0 00 00 00 00 00 24 00 00 00 42 00 01 00 00 00 00 00 00 00 00 00") +
    std::string(24, '\0');

struct Ready {
  LaserProfiler profiler{LaserProfilerOptions{}};
  Bench bench{profiler};
  Ready(const std::string& newest) {
    bench.open();
    bench.take();
    bench.feed(kProgramDone);
    bench.take();
    bench.feed(newest);
    REQUIRE(profiler.state() == DeviceState::kSafe);
  }
  void arm(int rows, const std::string& newest) {
    bench.command([&](std::int64_t t, Effects& fx) { profiler.arm(rows, t, fx); });
    REQUIRE(!bench.take().empty());
    bench.feed(newest);
    REQUIRE(profiler.state() == DeviceState::kArmed);
  }
  void poll(const std::string& newest) {
    while (bench.tx.empty()) REQUIRE(bench.advance_to_wake());
    bench.take();
    bench.feed(newest);
  }
};

}  // namespace

TEST_CASE("LJ-V requests equal the bytes of the card", "[laser]") {
  CHECK(test::hex(ljv::change_program(3).text()) ==
        "14 00 00 00 01 00 F0 00 00 00 00 00 08 00 00 00 39 00 00 00 03 00 00 00");
  CHECK(test::hex(ljv::get_newest_profile().text()) ==
        "20 00 00 00 01 00 F0 00 00 00 00 00 14 00 00 00 42 00 00 00 00 00 00 00 00 00 00 00 01 00 00 00 01 "
        "01 00 00");
}

TEST_CASE("the profiler speaks as its transcript says, whatever the split of the replies", "[laser]") {
  for (const std::size_t split : {0, 1, 3, 7}) {
    LaserProfiler profiler(LaserProfilerOptions{});
    test::play(
        profiler, kProfilerTranscripts + "ljv_scan.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) {
          if (c == "arm")
            profiler.arm(2, t, fx);
          else if (c == "end")
            profiler.end(t, fx);
        },
        split);
  }
}

TEST_CASE("20-bit samples decode like a bit-by-bit reading of the stream", "[laser]") {
  std::uint64_t seed = 42;
  std::vector<std::int32_t> values;
  for (int n = 0; n < 801; ++n) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    values.push_back(std::int32_t(seed >> 40 & 0xFFFFFu) - 0x80000);
  }
  const std::string reply = profile_reply(1, 0, values);
  ljv::RawProfile raw;
  REQUIRE(ljv::parse_profile(std::as_bytes(std::span(reply.data(), reply.size())), raw));
  REQUIRE(raw.points == 801);
  CHECK(raw.x0_mm == Approx(-5.0));
  CHECK(raw.dx_mm == Approx(0.02));
  for (std::size_t n = 0; n < values.size(); ++n) {
    std::int32_t v = 0;  // oracle: one bit after the other
    for (int b = 0; b < 20; ++b)
      v |= (std::uint8_t(reply[88 + (20 * n + std::size_t(b)) / 8]) >> (20 * n + std::size_t(b)) % 8 & 1)
           << b;
    if (v & 0x80000) v -= 0x100000;
    if (v <= -524'285)
      CHECK(std::isnan(raw.z_mm[n]));
    else
      CHECK(raw.z_mm[n] == Approx(v * 10 * 1e-5));
  }
}

TEST_CASE("the four invalid codes are not measured, their neighbour is", "[laser]") {
  const std::string reply = profile_reply(1, 0, {-524288, -524287, -524286, -524285, -524284, 0, 524287});
  ljv::RawProfile raw;
  REQUIRE(ljv::parse_profile(std::as_bytes(std::span(reply.data(), reply.size())), raw));
  for (int n = 0; n < 4; ++n) CHECK(std::isnan(raw.z_mm[std::size_t(n)]));
  for (int n = 4; n < 7; ++n) CHECK(std::isfinite(raw.z_mm[std::size_t(n)]));
}

TEST_CASE("a row is a new trigger count, counted from the arm, across the counter's wrap-around", "[laser]") {
  const std::uint32_t base = 0xFFFFFFFEu;
  Ready r(profile_reply(base, 0, {1}));
  r.arm(4, profile_reply(base, 0, {1}));
  r.poll(profile_reply(base, 0, {1}));           // old
  r.poll(profile_reply(base + 1, 100, {1, 2}));  // row 0
  r.poll(profile_reply(base + 1, 100, {1, 2}));  // the same again
  r.poll(profile_reply(base + 3, 300, {1, 2}));  // row 1 was missed
  r.poll(profile_reply(base + 4, 400, {1, 2}));  // last row
  const auto profiles = r.bench.all<ProfileRow>();
  REQUIRE(profiles.size() == 3);
  CHECK(profiles[0].row == 0);
  CHECK(profiles[1].row == 2);
  CHECK(profiles[2].row == 3);
  CHECK(profiles[2].encoder_count == 400);
  REQUIRE(r.bench.all<ScanDone>().size() == 1);
  CHECK(r.bench.all<ScanDone>()[0].rows_received == 3);
  CHECK(r.profiler.state() == DeviceState::kSafe);
}

TEST_CASE("a reply that lies about its length is never believed, never allocated for, never read beyond",
          "[laser]") {
  const std::string good = profile_reply(7, 70, std::vector<std::int32_t>(50, 1000));
  const ljv::LjvDialect dialect;
  const Request asked = ljv::get_newest_profile();
  const auto kind = [&](const std::string& s) {
    return dialect.frame(std::as_bytes(std::span(s.data(), s.size())), &asked).kind;
  };
  REQUIRE(kind(good) == Frame::Kind::kReply);
  for (const std::uint32_t length : {0u, 23u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu}) {
    std::string bad = good;
    put(bad, 0, length);
    CHECK(kind(bad) == Frame::Kind::kCorrupt);
  }
  ljv::RawProfile raw;
  for (std::size_t cut = 0; cut < good.size(); ++cut) {
    const std::vector<std::byte> exact(std::as_bytes(std::span(good.data(), cut)).begin(),
                                       std::as_bytes(std::span(good.data(), cut)).end());
    if (ljv::parse_profile(exact, raw)) CHECK(raw.points <= 50);
    if (cut < 28 + 60 + 125) CHECK((raw.points == 0));
  }
  for (const std::uint32_t points : {51u, 3201u, 65535u}) {
    std::string bad = good;
    put(bad, 28 + 24, points, 2);
    if (points * 20 / 8 <= 129) continue;
    CHECK_FALSE(ljv::parse_profile(std::as_bytes(std::span(bad.data(), bad.size())), raw));
  }
}

TEST_CASE("an error code is a named fault, not a profile", "[laser]") {
  Ready r(kNothingYet);
  r.arm(2, kNothingYet);
  std::string error = profile_reply(1, 0, {1});
  error[17] = 0x0B;
  r.poll(error);
  CHECK(r.bench.all<ProfileRow>().empty());
  REQUIRE(!r.bench.all<Fault>().empty());
  CHECK(r.bench.all<Fault>().back().text.find("42 answered with error 0B") != std::string::npos);
}

TEST_CASE("ending a scan asks once more and then says what was received", "[laser]") {
  Ready r(kNothingYet);
  r.arm(3, kNothingYet);
  r.poll(profile_reply(1, 10, {1}));
  r.bench.command([&](std::int64_t t, Effects& fx) { r.profiler.end(t, fx); });
  r.bench.take();
  r.bench.feed(profile_reply(2, 20, {1}));
  CHECK(r.bench.all<ProfileRow>().size() == 2);
  REQUIRE(r.bench.all<ScanDone>().size() == 1);
  CHECK(r.bench.all<ScanDone>()[0].rows_received == 2);
  CHECK(r.bench.all<Result>().back().outcome == Outcome::kDone);
}

namespace {

int link_stops(const Bench& bench) {
  int n = 0;
  for (const Fault& f : bench.all<Fault>()) n += f.severity == firn::Severity::kStop && f.code == kLinkLost;
  return n;
}

}  // namespace

TEST_CASE(
    "a profiler that falls silent between scans is a stop within seven seconds, told once for each silence",
    "[laser][I2]") {
  Ready r(kNothingYet);
  for (int n = 0; n < 60; ++n) r.poll(kNothingYet);
  CHECK(link_stops(r.bench) == 0);
  r.bench.advance_us(7'000'000);
  CHECK(link_stops(r.bench) == 1);
  r.bench.advance_us(30'000'000);
  CHECK(link_stops(r.bench) == 1);
  while (r.profiler.state() != DeviceState::kSafe) {  // it answers again
    while (r.bench.tx.empty()) {
      if (r.bench.reopens > 0) {
        r.bench.reopens = 0;
        r.bench.close();
        r.bench.open();
      } else {
        REQUIRE(r.bench.advance_to_wake());
      }
    }
    r.bench.feed(r.bench.take()[16] == 0x39 ? kProgramDone : kNothingYet);
  }
  r.bench.advance_us(7'000'000);
  CHECK(link_stops(r.bench) == 2);
}

TEST_CASE(
    "a profiler whose port is closed between scans and does not come back is a stop within seven seconds",
    "[laser][I2]") {
  Ready r(kNothingYet);
  r.bench.close();
  r.bench.advance_us(7'000'000);
  CHECK(link_stops(r.bench) == 1);
}
