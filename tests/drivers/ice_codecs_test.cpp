// The codecs of the path printer's instruments: vectors of the cards, round trips, damage.
#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/heater/thermostat.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/link/crc16.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/lossy_line.h"
#include "tests/support/laser_values.h"
#include "tests/support/thermostat_box.h"
#include "tests/support/valve_firmware.h"

using namespace firn::drivers;
using firn::drivers::test::bytes_of;
using firn::drivers::test::next;

namespace {

fvp::Counts some_point(std::uint64_t& seed, bool far) {
  const auto within = [&](std::int32_t low, std::int32_t high) {
    return far ? low : std::int32_t(low + std::int64_t(next(seed) % std::uint64_t(high - low + 1)));
  };
  return {within(-1'050'000, 1'050'000), within(-1'500'000, 1'500'000),
          within(0, 210'000) + (far ? 210'000 : 0), within(-3'600'000, 3'600'000)};
}

// Every frame of `frames` arrives whole however the bytes are cut, and nothing else does.
template <class Count>
void check_splits(const Dialect& dialect, const std::string& bytes, Count&& counted) {
  std::uint64_t seed = 5;
  for (int round = 0; round < 50; ++round) {
    std::string held;
    int found = 0;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t n = 1 + next(seed) % 40;
      held += bytes.substr(at, n);
      at += n;
      while (!held.empty()) {
        const Frame f = dialect.frame(bytes_of(held), nullptr);
        if (f.kind == Frame::Kind::kIncomplete) break;
        REQUIRE(f.size > 0);
        found += f.kind != Frame::Kind::kCorrupt;
        held.erase(0, f.size);
      }
    }
    CHECK(held.empty());
    CHECK(found == counted());
  }
}

}  // namespace

TEST_CASE("CRC-16 and robot lines equal the vectors of the card", "[robot]") {
  CHECK(crc16("123456789") == 0x29B1);
  CHECK(crc16("456789", crc16("123")) == 0x29B1);
  CHECK(fvp::request(17, "HELLO").word("FIRN").word(1).finish(1) == "@17 HELLO FIRN 1*E003\r\n");
  CHECK(fvp::request(17, "ACK").text(" OK C40 1 TICK=0.016").finish(1) ==
        "@17 ACK OK C40 1 TICK=0.016*2E32\r\n");
  CHECK(fvp::request(20, "ESTOP").finish(1) == "@20 ESTOP*8D10\r\n");
  CHECK(fvp::request(18, "PATH BEGIN").word(42).text(" N=512 DT=0.016").finish(1) ==
        "@18 PATH BEGIN 42 N=512 DT=0.016*8D53\r\n");
}

TEST_CASE("a robot line is parsed only when every character of it is right", "[robot]") {
  const std::string good(fvp::event(3, "PATH_DONE").word(42).word(8123).finish(1));
  const fvp::Message m = fvp::parse(good);
  REQUIRE(m.kind == fvp::Message::Kind::kEvent);
  CHECK(m.seq == 3);
  CHECK(m.text == "PATH_DONE 42 8123");
  for (std::size_t bit = 0; bit < (good.size() - 2) * 8; ++bit) {
    std::string bad = good;
    bad[bit / 8] = char(bad[bit / 8] ^ (1 << bit % 8));
    CHECK(fvp::parse(bad).kind == fvp::Message::Kind::kBad);
  }
  for (const char* text : {"", "@", "@*FFFF", "@x ACK*0000", "@1*0000", "hello\r\n", "@70000 ACK*0000"})
    CHECK(fvp::parse(text).kind == fvp::Message::Kind::kBad);
}

TEST_CASE("joints go over the wire within half a count and come back to the same counts", "[robot]") {
  std::uint64_t seed = 3;
  for (int n = 0; n < 10'000; ++n) {
    const fvp::Counts counts = some_point(seed, false);
    CHECK(fvp::counts_of(fvp::joints_of(counts)) == counts);
    LineWriter line;
    fvp::put(line, counts);
    WordReader words(line.so_far());
    CHECK(fvp::parse_counts(words) == counts);
  }
  CHECK(fvp::counts_of({std::acos(-1.0) / 2, 0.0, 209.9996, 0.0}) == fvp::Counts{900'000, 0, 210'000, 0});
}

TEST_CASE(
    "path blocks carry every point once, in lines of at most 120 characters, and only the last is answered",
    "[robot]") {
  std::uint64_t seed = 9;
  for (int round = 0; round < 200; ++round) {
    std::vector<fvp::Counts> points;
    const std::size_t n = 1 + next(seed) % 300;
    for (std::size_t k = 0; k < n; ++k) points.push_back(some_point(seed, round % 3 == 0));
    fvp::FvpDialect dialect;
    dialect.points = points;
    const std::size_t first = next(seed) % n, count = 1 + next(seed) % (n - first);
    std::vector<std::byte> tx;
    dialect.write(fvp::path_block(65535, first, count, 0), tx);
    std::string all(text_of(tx));
    std::vector<fvp::Counts> got;
    fvp::PointsCrc crc, direct;
    while (!all.empty()) {
      const std::string line = all.substr(0, all.find('\n') + 1);
      all.erase(0, line.size());
      CHECK(line.size() <= 120);
      const fvp::Message m = fvp::parse(line);
      REQUIRE(m.kind == fvp::Message::Kind::kNumbered);
      CHECK(m.seq == (all.empty() ? 65535 : fvp::kUnanswered));
      WordReader words(m.text);
      CHECK(words.word() == "PATH");
      CHECK(words.word() == "P");
      CHECK(words.number(0, fvp::kMaxPoints) == std::int64_t(first + got.size()));
      crc.add(words.rest().substr(1));
      while (!words.at_end()) got.push_back(fvp::parse_counts(words).value());
    }
    REQUIRE(got.size() == count);
    CHECK(std::equal(got.begin(), got.end(), points.begin() + std::ptrdiff_t(first)));
    for (const fvp::Counts& p : got) direct.add(p);
    CHECK(crc.value() == direct.value());
  }
}

TEST_CASE("the robot's status survives the longest values and refuses what is out of range", "[robot]") {
  fvp::Status s;
  s.state = fvp::State::kRunning;
  s.state1 = 99;
  s.state2 = 99;
  s.boot_count = 99'999;
  s.power = s.calibrated = s.last_done = true;
  s.speed_percent = 999;
  s.error = -9999;
  s.running = s.last = s.held[0] = s.held[1] = std::int32_t(fvp::kMaxId);
  s.at = fvp::kMaxPoints;
  s.last_ms = 9'999'999;
  LineWriter line = fvp::request(65535, "ACK");
  fvp::put(line, s);
  const std::string text(line.finish(1));
  CHECK_FALSE(line.overflow());
  CHECK(text.size() <= 120);
  WordReader words(fvp::parse(text).text);
  CHECK(words.word() == "ACK");
  CHECK(fvp::parse_status(words) == s);
  for (const char* bad :
       {"RUNNING", "NAPPING 7 1 1 1 1 100 0 0 0 0 0 0 0 0", "IDLE 7 1 1 2 1 100 0 0 0 0 0 0 0 0",
        "IDLE 7 1 1 1 1 100 0 0 9000 0 0 0 0 0", "IDLE 7 1 1 1 1 100 0 0 0 0 0 0 0 0 0"}) {
    WordReader w(bad);
    CHECK_FALSE(fvp::parse_status(w));
  }
}

TEST_CASE("of two sequence numbers exactly one is newer, over the wrap too", "[robot][valve]") {
  for (std::int64_t a = 1; a <= fvp::kMaxSeq; a += 97) {
    CHECK(fvp::newer(fvp::next_seq(a), a));
    CHECK_FALSE(fvp::newer(a, a));
    for (std::int64_t b = 1; b <= fvp::kMaxSeq; b += 1013)
      if (a != b) CHECK(fvp::newer(a, b) != fvp::newer(b, a));
  }
  for (int a = 1; a <= 255; ++a)
    for (int b = 1; b <= 255; ++b) {
      CHECK(fvb::newer(fvb::next_seq(std::uint8_t(a)), std::uint8_t(a)));
      if (a != b)
        CHECK(fvb::newer(std::uint8_t(a), std::uint8_t(b)) != fvb::newer(std::uint8_t(b), std::uint8_t(a)));
    }
}

TEST_CASE("valve frames equal bytes worked out by hand and come back as they were", "[valve]") {
  std::vector<std::byte> out;
  fvb::encode(fvb::Type::kArm, 7, bytes_of(std::string_view("\x10\x27\x00\x00", 4)), out);
  // CRC over 05 07 04 00 10 27 00 00, by a script that knows only the polynomial.
  CHECK(test::hex(text_of(out)) == "A5 5A 05 07 04 00 10 27 00 00 94 7E");
  const fvb::Found f = fvb::find(out);
  REQUIRE(f.kind == fvb::Found::Kind::kFrame);
  CHECK(f.type == fvb::Type::kArm);
  CHECK(f.seq == 7);
  CHECK(fvb::parse_number(f.payload) == 10'000u);
  out.clear();
  const fvb::Status s{9, fvb::State::kFiring, 123'456'789, 16'384, 131'072'000, 65'535};
  fvb::encode(255, s, out);
  CHECK(fvb::parse_status(fvb::find(out).payload) == s);
  out.clear();
  fvb::encode(1, fvb::Begin{77, 2, 16'384, 2000, 1250}, out);
  const auto begin = fvb::parse_begin(fvb::find(out).payload);
  REQUIRE(begin);
  CHECK(begin->path == 77);
  CHECK(begin->entries == 16'384);
  CHECK(begin->pulse_us == 1250);
}

TEST_CASE("no flipped bit of a valve frame passes, and the frame after it is still found", "[valve]") {
  std::vector<std::byte> frame;
  const std::vector<std::uint16_t> ticks{1, 5, 9, 65'535};
  fvb::encode_data(3, 12, ticks, frame);
  std::vector<std::byte> after;
  fvb::encode_ack(4, 1, after);
  for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
    std::vector<std::byte> stream = frame;
    stream[bit / 8] ^= std::byte(1 << bit % 8);
    stream.insert(stream.end(), after.begin(), after.end());
    stream.insert(stream.end(), fvb::kMaxPayload, std::byte(0));  // so that a longer length is complete too
    std::span<const std::byte> left = stream;
    int frames = 0;
    while (!left.empty()) {
      const fvb::Found f = fvb::find(left);
      if (f.kind == fvb::Found::Kind::kIncomplete) break;
      if (f.kind == fvb::Found::Kind::kFrame) {
        ++frames;
        CHECK(f.type == fvb::Type::kAck);
        CHECK(f.seq == 4);
      }
      left = left.subspan(f.size);
    }
    CHECK(frames == 1);
  }
}

TEST_CASE("a pulse list is cut into data frames and comes together again", "[valve]") {
  std::vector<std::uint16_t> ticks;
  for (int n = 0; n < 16'384; ++n) ticks.push_back(std::uint16_t(4 * n));
  fvb::FvbDialect dialect;
  dialect.ticks = ticks;
  std::vector<std::uint16_t> got;
  for (std::size_t at = 0; at < ticks.size(); at += fvb::kEntriesPerFrame) {
    std::vector<std::byte> tx;
    dialect.write(fvb::data(1, at, std::min(fvb::kEntriesPerFrame, ticks.size() - at)), tx);
    CHECK(tx.size() <= fvb::kHead + fvb::kMaxPayload + fvb::kTail);
    const auto d = fvb::parse_data(fvb::find(tx).payload);
    REQUIRE(d);
    CHECK(d->offset == at);
    for (std::size_t n = 0; n < d->entries; ++n) got.push_back(d->tick(n));
  }
  CHECK(got == ticks);
  CHECK(fvb::list_crc(got) == fvb::list_crc(ticks));
}

TEST_CASE("laser values are numbers only where the manual says so", "[laser_point]") {
  using lkg::Status;
  const auto status = [](std::string_view t) { return lkg::parse_value(t).status; };
  CHECK(lkg::parse_value("+01.2345").mm == 1.2345);
  CHECK(lkg::parse_value("-00.0120").mm == -0.012);
  CHECK(lkg::parse_value("-00001.2").mm == -1.2);
  CHECK(status("XXXXXXXX") == Status::kNoValue);
  CHECK(status("+FFFFFFF") == Status::kAbove);
  CHECK(status("-FFFFFFF") == Status::kBelow);
  for (const char* bad :
       {"", "+01.234", "+01.23456", "01.23456", "+1.2e+03", "+-1.2345", "+1234567", "+.123456", "+123456.",
        "+01,2345", "+0x1.234", "+    1.2", "+inf0000", "+FFFFFF0", "XXXXXXX0"}) {
    INFO(bad);
    CHECK(status(bad) == Status::kDamaged);
    CHECK(std::isnan(lkg::parse_value(bad).mm));
  }
  CHECK(std::isnan(lkg::parse_value("+FFFFFFF").mm));
  std::uint64_t seed = 1;
  for (int n = 0; n < 10'000; ++n) {
    const double mm = (double(next(seed) % 100'000) - 50'000.0) * 1e-4;
    char text[lkg::kValueChars];
    lkg::put_value(mm, text);
    CHECK(std::abs(lkg::parse_value({text, sizeof text}).mm - mm) < 1e-9);
  }
  char text[lkg::kValueChars];
  lkg::put_value(std::nan(""), text);
  CHECK(status({text, sizeof text}) == Status::kNoValue);
  lkg::put_value(-120.0, text);
  CHECK(status({text, sizeof text}) == Status::kBelow);
}

TEST_CASE("a laser reply belongs to its command, and timing values and errors are told apart",
          "[laser_point]") {
  using Kind = lkg::Reply::Kind;
  CHECK(lkg::parse("M1,+01.2345", "M1").rest == "+01.2345");
  CHECK(lkg::parse("R0", "R0").kind == Kind::kDone);
  CHECK(lkg::parse("SW,CA", "SW,CA,5").kind == Kind::kDone);
  CHECK(lkg::parse("SW,HB", "SW,CA,5").kind == Kind::kForeign);
  CHECK(lkg::parse("M1,+01.2345", "PR").kind == Kind::kForeign);
  CHECK(lkg::parse("TG,1,+01.2345", "M1").kind == Kind::kTiming);
  CHECK(lkg::parse("ER,M1,01", "M1").error == 1);
  CHECK(lkg::parse("ER,M1,1", "M1").kind == Kind::kForeign);
  CHECK(lkg::parse("ER,PR,01", "M1").kind == Kind::kForeign);
  std::vector<float> mm;
  CHECK(lkg::parse_dump("1,+01.2345,XXXXXXXX,+FFFFFFF,-00.0120", mm) == 0);
  REQUIRE(mm.size() == 4);
  CHECK(mm[0] == 1.2345f);
  CHECK(std::isnan(mm[1]));
  CHECK(std::isnan(mm[2]));
  CHECK(mm[3] == -0.012f);
  CHECK(lkg::parse_dump("1,+01.2345,+01.x345", mm) == 1);
  CHECK_FALSE(lkg::parse_dump("1,+01.2345,+01.23", mm));
  CHECK_FALSE(lkg::parse_dump("2,+01.2345", mm));
  CHECK(lkg::parse_stored("1,13107").value().values == 13'107);
  CHECK_FALSE(lkg::parse_stored("1,-3"));
}

TEST_CASE("laser counts come for one output or for both, and a dump with or without its output's number",
          "[laser_point]") {
  for (const char* both : {"1,13107,0", "1,13107,13107"})
    CHECK(lkg::parse_stored(both).value().values == 13'107);
  for (const char* bad : {"1,13107,", "1,13107,-1", "1,13107,1,1", "1,13107,x", "1,,5"})
    CHECK_FALSE(lkg::parse_stored(bad));
  std::vector<float> mm;
  CHECK(lkg::parse_dump("+01.2345,XXXXXXXX,-FFFFFFF", mm) == 0);
  REQUIRE(mm.size() == 3);
  CHECK(mm[0] == 1.2345f);
  CHECK(lkg::parse_dump("+01.2345", mm) == 0);
  CHECK(mm.size() == 1);
  CHECK_FALSE(lkg::parse_dump("+01.2345,", mm));
  CHECK_FALSE(lkg::parse_dump("", mm));
}

TEST_CASE("a laser refuses a setting by its identifier or by SW", "[laser_point]") {
  for (const char* reply : {"ER,HB,22", "ER,SW,22"}) CHECK(lkg::parse(reply, "SW,HB,1,9").error == 22);
  CHECK(lkg::parse("ER,CA,22", "SW,HB,1,9").kind == lkg::Reply::Kind::kForeign);
}

TEST_CASE("heater lines carry temperatures to 0.01 degC, and an open thermocouple is no number", "[heater]") {
  thermostat::Reading r{{21.37, std::nan(""), -19.5}, {true, false, true}};
  LineWriter line;
  put(line, r);
  CHECK(line.so_far() == "T,2137,OPEN,-1950,5");
  const std::string whole(line.finish(0));
  const auto back = thermostat::parse_reading(checked_text(whole, 0).value());
  REQUIRE(back);
  CHECK(back->celsius[0] == 21.37);
  CHECK(std::isnan(back->celsius[1]));
  CHECK(back->heating == r.heating);
  for (const char* bad :
       {"T,1,2,3", "T,1,2,3,8", "T,1,2,99999,0", "T,1,OPENED,3,0", "T,1,2,3,0,0", "U,1,2,3,0"})
    CHECK_FALSE(thermostat::parse_reading(bad));
  CHECK(thermostat::parse_set_point("S,2,2500") == thermostat::SetPoint{2, 2500});
  CHECK_FALSE(thermostat::parse_set_point("S,4,2500"));
  const thermostat::ThermostatDialect dialect;
  const Request asked = thermostat::read_request(0);
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    std::string bad = whole;
    bad[bit / 8] = char(bad[bit / 8] ^ (1 << bit % 8));
    CHECK((dialect.frame(bytes_of(bad), &asked).kind != Frame::Kind::kReply ||
           bit / 8 == whole.size() - 2));  // the CR before LF carries nothing
  }
}

TEST_CASE("frames are the same however the bytes are cut", "[robot][valve][laser_point][heater]") {
  std::string robot, laser, heater;
  std::vector<std::byte> valve;
  for (int n = 1; n <= 20; ++n) {
    robot += fvp::request(n, "ACK").word(n * 1000).finish(1);
    robot += fvp::event(n, "MOVE_DONE").finish(1);
    fvb::encode(std::uint8_t(n), fvb::Status{1, fvb::State::kDone, 0xA55AA55A, 0xA55A % 16'000, 0, 0}, valve);
    laser += "TG,1,+01.2345\r";
    LineWriter line;
    heater += line.text("T,").number(n).text(",1,2,0").finish(0);
  }
  check_splits(fvp::FvpDialect(), robot, [] { return 40; });
  check_splits(fvb::FvbDialect(), std::string(text_of(valve)), [] { return 20; });
  check_splits(lkg::LkgDialect(), laser, [] { return 20; });
  check_splits(thermostat::ThermostatDialect(), heater, [] { return 20; });
}
