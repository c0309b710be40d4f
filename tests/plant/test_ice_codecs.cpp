// The path printer's instruments have two codecs each, the drivers' and the twins': both against the cards'
// examples, and against each other over seeded messages.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/grid/random.h"
#include "drivers/heater/thermostat.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/link/crc16.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "plant/twins/fvb.h"
#include "plant/twins/fvp.h"
#include "plant/twins/lines.h"
#include "plant/twins/lkg.h"
#include "tests/support/laser_values.h"
#include "tests/support/thermostat_box.h"
#include "tests/support/valve_firmware.h"

using namespace firn;
namespace host_fvp = firn::drivers::fvp;
namespace host_fvb = firn::drivers::fvb;
namespace host_lkg = firn::drivers::lkg;
namespace fvp = firn::plant::fvp;
namespace fvb = firn::plant::fvb;

namespace {

constexpr int kMessages = 2000;

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// Lines of a transcript that begin with '>' (the host's) or '<' (the instrument's), as bytes.
struct TranscriptLine {
  bool host = false;
  std::string bytes;
};
std::vector<TranscriptLine> transcript(const std::string& name) {
  std::ifstream in(std::filesystem::path(FIRN_SOURCE_DIR) / "tests/drivers/transcripts" / name);
  std::vector<TranscriptLine> lines;
  bool hex = false;
  for (std::string text; std::getline(in, text);) {
    hex |= text == "hex";
    if (text.size() < 3 || (text[0] != '>' && text[0] != '<')) continue;
    TranscriptLine line{text[0] == '>', {}};
    if (hex) {
      std::istringstream digits(text.substr(2));
      for (unsigned byte = 0; digits >> std::hex >> byte;) line.bytes += char(byte);
    } else {
      for (std::size_t n = 2; n < text.size(); ++n)
        line.bytes += text[n] != '\\' ? text[n] : text[++n] == 'r' ? '\r' : '\n';
    }
    lines.push_back(line);
  }
  REQUIRE(lines.size() > 10);
  return lines;
}

std::int32_t whole(RandomStream& random, std::int32_t most) {
  return std::int32_t(random.below(std::uint32_t(most) + 1));
}
/// Of every number of digits, so that short and long ones both come.
std::int32_t any_size(RandomStream& random, std::int32_t most) {
  std::int32_t limit = 9;
  for (int more = whole(random, 9); more > 0 && limit < most; --more)
    limit = std::min(most / 10, limit) * 10 + 9;
  return whole(random, std::min(limit, most));
}
fvp::Point some_point(RandomStream& random) {
  fvp::Point point{};
  for (std::int32_t& count : point)
    count = any_size(random, host_fvp::kMaxCount) * (whole(random, 1) ? 1 : -1);
  return point;
}

}  // namespace

TEST_CASE("the twins' checksums and lines equal the vectors of the cards") {
  CHECK(plant::RemainderCcitt().add("123456789").value() == 0x29B1);
  CHECK(plant::RemainderCcitt().add("123").add("456789").value() == 0x29B1);
  CHECK(fvp::reply_line(17, "HELLO FIRN 1") == "@17 HELLO FIRN 1*E003\r\n");
  CHECK(fvp::reply_line(17, "ACK OK C40 1 TICK=0.016") == "@17 ACK OK C40 1 TICK=0.016*2E32\r\n");
  CHECK(fvp::reply_line(20, "ESTOP") == "@20 ESTOP*8D10\r\n");
  CHECK(fvp::reply_line(18, "PATH BEGIN 42 N=512 DT=0.016") == "@18 PATH BEGIN 42 N=512 DT=0.016*8D53\r\n");
  CHECK(plant::lkg::value(1.2345) == "+01.2345");
  CHECK(plant::lkg::value(-0.012) == "-00.0120");
  CHECK(plant::lkg::value(-2.3122) == "-02.3122");
  CHECK(plant::lkg::value(std::nan("")) == "XXXXXXXX");
  CHECK(plant::lkg::value(std::numeric_limits<double>::infinity()) == "+FFFFFFF");
  CHECK(plant::lkg::value(-100.0) == "-FFFFFFF");
  CHECK(plant::lkg::refused("M1", plant::lkg::Error::kStatus) == "ER,M1,01");
  CHECK(plant::lkg::refused("R0", plant::lkg::Error::kStatus) == "ER,R0,01");
  CHECK(plant::lkg::refused("SW,OF,1,X", plant::lkg::Error::kCommand) == "ER,OF,00");
}

TEST_CASE("both codecs take every line of the transcripts for the same, and the twins write the replies") {
  for (const TranscriptLine& line : transcript("fvp_run_path.txt")) {
    INFO(line.bytes);
    const auto host = host_fvp::parse(line.bytes);
    REQUIRE(host.kind != host_fvp::Message::Kind::kBad);
    if (host.kind == host_fvp::Message::Kind::kEvent) {
      CHECK(fvp::event_line(host.seq, host.text) == line.bytes);
      continue;
    }
    const auto request = fvp::request_of(line.bytes);
    REQUIRE(request);
    CHECK(request->number == host.seq);
    CHECK(request->text == host.text);
    if (!line.host) CHECK(fvp::reply_line(host.seq, host.text) == line.bytes);
  }
  for (const TranscriptLine& line : transcript("heater_set.txt")) {
    INFO(line.bytes);
    const auto text = plant::unsealed(line.bytes);
    CHECK(text.has_value() == drivers::checked_text(line.bytes, 0).has_value());
    if (text) CHECK(plant::sealed(*text) == line.bytes);
  }
  for (const TranscriptLine& line : transcript("fvb_fire_list.txt")) {
    const fvb::Intake in = fvb::take_in(bytes_of(line.bytes));
    REQUIRE(in.good);
    CHECK(in.size == line.bytes.size());
    const host_fvb::Found found = host_fvb::find(bytes_of(line.bytes));
    CHECK(int(in.kind) == int(found.type));
    CHECK(in.number == found.seq);
    const std::uint16_t boots = 7;
    if (line.host) continue;
    if (in.kind == fvb::Kind::kAck) CHECK(fvb::ack(in.number, boots) == line.bytes);
    if (in.kind == fvb::Kind::kHello) CHECK(fvb::hello(in.number, boots, 3, 0) == line.bytes);
    if (in.kind != fvb::Kind::kStatus) continue;
    const auto s = host_fvb::parse_status(found.payload).value();
    CHECK(fvb::status(in.number, boots, {fvb::State(s.state), s.path, s.next, s.since_us, s.late_us}) ==
          line.bytes);
  }
}

TEST_CASE("robot: replies of the twin and of the driver's codec are equal byte by byte") {
  RandomStream random(1, Purpose::kTest);
  for (int n = 0; n < kMessages; ++n) {
    const std::int64_t seq = any_size(random, 65534) + 1;
    fvp::Report r;
    r.state = fvp::State(whole(random, 7));
    r.state_1 = any_size(random, 99);
    r.state_2 = any_size(random, 99);
    r.boots = std::uint32_t(any_size(random, 99'999));
    r.power = whole(random, 1);
    r.calibrated = whole(random, 1);
    r.speed_percent = any_size(random, 100);
    r.error = any_size(random, 9999) * (whole(random, 1) ? 1 : -1);
    r.running_path = any_size(random, 9'999'999);
    r.points_passed = any_size(random, 8192);
    r.ended_path = any_size(random, 9'999'999);
    r.reached_end = whole(random, 1);
    r.ended_ms = any_size(random, 200'000);
    r.slots = {any_size(random, 9'999'999), any_size(random, 9'999'999)};
    const std::string line = fvp::reply_line(seq, "ACK " + fvp::text_of(r));
    INFO(line);
    const host_fvp::Message m = host_fvp::parse(line);
    REQUIRE(m.kind == host_fvp::Message::Kind::kNumbered);
    drivers::WordReader words(m.text);
    CHECK(words.word() == "ACK");
    const auto s = host_fvp::parse_status(words);
    REQUIRE(s);
    CHECK(host_fvp::name(s->state) == fvp::word_of(r.state));
    CHECK(s->boot_count == std::int32_t(r.boots));
    CHECK(s->at == r.points_passed);
    CHECK(s->last == r.ended_path);
    CHECK(s->held == r.slots);
    drivers::LineWriter same = host_fvp::request(seq, "ACK");
    host_fvp::put(same, *s);
    CHECK(same.finish(1) == line);

    const fvp::Point point = some_point(random);
    drivers::LineWriter event = host_fvp::event(seq, "MOVE_DONE");
    host_fvp::put(event, point);
    CHECK(event.finish(1) == fvp::event_line(seq, "MOVE_DONE " + fvp::text_of(point)));
    CHECK(host_fvp::joints_of(point) == fvp::joints_at(point));
    CHECK(fvp::nearest_point(fvp::joints_at(point)) == point);
    for (const std::int64_t b : {seq, std::int64_t(any_size(random, 65534) + 1)})
      CHECK(fvp::is_newer(b, seq) == host_fvp::newer(b, seq));
  }
}

TEST_CASE("robot: the twin reads from the driver's path blocks the points and the sum that were sent") {
  RandomStream random(2, Purpose::kTest);
  for (int n = 0; n < 200; ++n) {
    std::vector<fvp::Point> points(1 + random.below(200));
    for (fvp::Point& p : points) p = some_point(random);
    host_fvp::FvpDialect dialect;
    dialect.points = points;
    std::vector<std::byte> sent;
    dialect.write(host_fvp::path_block(77, 0, points.size(), 0), sent);
    std::istringstream lines(text_of(sent));
    std::vector<fvp::Point> read;
    std::int64_t last = 0;
    for (std::string line; std::getline(lines, line);) {
      const auto request = fvp::request_of(line += '\n');
      REQUIRE(request);
      last = request->number;
      plant::Words words(request->text);
      CHECK(words.next() == "PATH");
      CHECK(words.next() == "P");
      CHECK(words.integer(0, fvp::kMaxPoints) == std::int64_t(read.size()));
      while (words.more()) read.push_back(fvp::next_point(words).value());
    }
    CHECK(last == 77);
    CHECK(read == points);
    host_fvp::PointsCrc sum;
    for (const fvp::Point& p : points) sum.add(p);
    CHECK(fvp::checksum(points) == sum.value());
  }
}

TEST_CASE("robot: a line of which any bit is flipped or any part is missing is no request") {
  const std::string good = fvp::reply_line(300, "PATH P 0 1 -22 333 -4444");
  REQUIRE(fvp::request_of(good));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    std::string bad = good;
    bad[bit / 8] = char(bad[bit / 8] ^ 1 << bit % 8);
    CHECK_FALSE(fvp::request_of(bad));
  }
  for (std::size_t n = 0; n < good.size(); ++n) CHECK_FALSE(fvp::request_of(good.substr(0, n)));
  CHECK_FALSE(fvp::request_of(fvp::reply_line(65536, "STAT")));
  CHECK_FALSE(fvp::request_of(fvp::reply_line(-1, "STAT")));
  CHECK_FALSE(fvp::request_of(fvp::reply_line(1, "")));
  CHECK(fvp::request_of(fvp::reply_line(1, std::string(109, 'X'))));  // 120 characters with CR LF
  CHECK_FALSE(fvp::request_of(fvp::reply_line(1, std::string(111, 'X'))));
}

TEST_CASE("valve: frames of the twin and of the driver's codec are equal byte by byte") {
  RandomStream random(3, Purpose::kTest);
  for (int n = 0; n < kMessages; ++n) {
    const auto seq = std::uint8_t(1 + random.below(255));
    const auto boots = std::uint16_t(any_size(random, 65535));
    std::vector<std::byte> bytes;
    host_fvb::encode(seq, host_fvb::Hello{boots, 3, 2}, bytes);
    CHECK(text_of(bytes) == fvb::hello(seq, boots, 3, 2));
    bytes.clear();
    host_fvb::encode_ack(seq, boots, bytes);
    CHECK(text_of(bytes) == fvb::ack(seq, boots));
    bytes.clear();
    host_fvb::encode_nak(seq, boots, host_fvb::Refusal::kOrder, bytes);
    CHECK(text_of(bytes) == fvb::nak(seq, boots, fvb::Nak::kOrder));
    bytes.clear();
    const host_fvb::Status s{boots,
                             host_fvb::State(whole(random, 6)),
                             std::uint32_t(any_size(random, 2'000'000'000)),
                             std::uint16_t(any_size(random, 16384)),
                             std::uint32_t(any_size(random, 2'000'000'000)),
                             std::uint16_t(any_size(random, 65535))};
    host_fvb::encode(seq, s, bytes);
    CHECK(text_of(bytes) ==
          fvb::status(seq, boots, {fvb::State(s.state), s.path, s.next, s.since_us, s.late_us}));
    for (const auto b : {seq, std::uint8_t(1 + random.below(255))})
      CHECK(fvb::is_newer(b, seq) == host_fvb::newer(b, seq));
  }
}

TEST_CASE("valve: the twin reads from the driver's frames the list, the waits and the sum that were sent") {
  RandomStream random(4, Purpose::kTest);
  for (int n = 0; n < 200; ++n) {
    std::vector<std::uint16_t> ticks(1 + random.below(1000));
    for (std::uint16_t& t : ticks) t = std::uint16_t(random.below(65536));
    const host_fvb::Begin begin{random.below(1u << 31), std::uint8_t(1 + random.below(2)),
                                std::uint16_t(ticks.size()), std::uint16_t(random.below(65536)),
                                std::uint16_t(random.below(65536))};
    std::vector<std::byte> sent;
    host_fvb::FvbDialect dialect;
    dialect.ticks = ticks;
    dialect.write(host_fvb::begin(1, begin), sent);
    for (std::size_t at = 0; at < ticks.size(); at += host_fvb::kEntriesPerFrame)
      dialect.write(host_fvb::data(2, at, std::min(host_fvb::kEntriesPerFrame, ticks.size() - at)), sent);
    dialect.write(host_fvb::number16(host_fvb::Type::kEnd, 3, host_fvb::list_crc(ticks)), sent);
    dialect.write(host_fvb::number32(host_fvb::Type::kArm, 4, begin.path, drivers::Repeat::kSetup), sent);
    std::vector<std::uint16_t> list;
    std::span<const std::byte> left = sent;
    std::string kinds;
    while (!left.empty()) {
      const fvb::Intake in = fvb::take_in(left);
      REQUIRE(in.good);
      left = left.subspan(in.size);
      if (kinds.empty() || kinds.back() != char('0' + int(in.kind))) kinds += char('0' + int(in.kind));
      if (in.kind == fvb::Kind::kBegin) {
        const auto head = fvb::head_of(in.payload).value();
        CHECK(head.path == begin.path);
        CHECK(head.valve == begin.valve);
        CHECK(head.entries == begin.entries);
        CHECK(head.tick_us == begin.tick_us);
        CHECK(head.pulse_us == begin.pulse_us);
      } else if (in.kind == fvb::Kind::kData) {
        const auto part = fvb::part_of(in.payload).value();
        CHECK(part.offset == list.size());
        list.insert(list.end(), part.ticks.begin(), part.ticks.end());
      } else if (in.kind == fvb::Kind::kEnd) {
        CHECK(fvb::checksum_of(in.payload) == fvb::checksum(list));
      } else {
        CHECK(fvb::wait_ms_of(in.payload) == begin.path);
      }
    }
    CHECK(kinds == "2345");
    CHECK(list == ticks);
  }
}

TEST_CASE("valve: no flipped bit passes, and the frame behind a damaged one is found by both codecs") {
  const std::string frame = fvb::status(9, 1, {fvb::State::kDone, 0xA55AA55A, 3, 4, 5}),
                    next = fvb::ack(10, 1);
  for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
    std::string damaged = frame;
    damaged[bit / 8] = char(damaged[bit / 8] ^ 1 << bit % 8);
    const std::string stream = damaged + next + std::string(512, '\0');
    int good = 0;
    std::span<const std::byte> left = bytes_of(stream);
    while (!left.empty()) {
      const fvb::Intake in = fvb::take_in(left);
      if (in.size == 0) break;
      if (in.good) {
        ++good;
        CHECK(in.number == 10);
      }
      left = left.subspan(in.size);
    }
    CHECK(good == 1);
  }
  for (std::size_t n = 0; n < frame.size(); ++n) CHECK_FALSE(fvb::take_in(bytes_of(frame).first(n)).good);
}

TEST_CASE("heater: the driver reads what the twin says, to 0.01 degC, and the twin what the driver asks") {
  RandomStream random(5, Purpose::kTest);
  for (int n = 0; n < kMessages; ++n) {
    const auto request =
        drivers::thermostat::set_request({1 + whole(random, 2), any_size(random, 45'000) - 5000}, 0);
    const auto text = plant::unsealed(request.text());
    REQUIRE(text);
    CHECK(plant::sealed(*text) == request.text());
    drivers::thermostat::Reading r;
    for (double& degC : r.celsius)
      degC = whole(random, 9) ? (any_size(random, 45'000) - 5000) / 100.0 : std::nan("");
    for (bool& on : r.heating) on = whole(random, 1);
    drivers::LineWriter line;
    drivers::thermostat::put(line, r);
    const std::string reading(line.finish(0));
    const auto back = plant::unsealed(reading);
    REQUIRE(back);
    CHECK(plant::sealed(*back) == reading);
  }
  CHECK(plant::unsealed(drivers::thermostat::read_request(0).text()) == "T?");
}

TEST_CASE("laser: values of the twin and of the driver's codec are equal, and the driver reads the replies") {
  RandomStream random(6, Purpose::kTest);
  for (int n = 0; n < kMessages; ++n) {
    const double mm = random.uniform(-1.0, 1.0) * (n % 4 == 0 ? 120.0 : 5.0);
    if (std::abs(std::abs(mm) - 99.9999) < 1e-4) continue;
    char text[host_lkg::kValueChars];
    host_lkg::put_value(mm, text);
    CHECK(plant::lkg::value(mm) == std::string(text, sizeof text));
    const host_lkg::Value value = host_lkg::parse_value(plant::lkg::value(mm));
    if (std::abs(mm) < 99.0) CHECK(std::abs(value.mm - mm) <= 0.500001e-4);
  }
  for (const char* command : {"M1", "PR", "Q0", "SW,CA,5", "SW,HB,1,9", "AO,1"})
    for (const auto error :
         {plant::lkg::Error::kCommand, plant::lkg::Error::kStatus, plant::lkg::Error::kParameter}) {
      const std::string reply = plant::lkg::refused(command, error);
      INFO(command << " -> " << reply);
      const host_lkg::Reply read = host_lkg::parse(reply, command);
      CHECK(read.kind == host_lkg::Reply::Kind::kError);
      CHECK(read.error == int(error));
    }
}
