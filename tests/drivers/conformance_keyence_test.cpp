// Replies of Keyence instruments that independent code bases and golden replies give, against codec and twin.
// Sources: [I] ISIS EPICS-DeviceEmulator keylkg and its IOC tests, [L] LaserMetaData logger of an LK-G5000,
// [D] DESY cmstkmodlab, [Q] keyence-lk-g5000; of the LJ-V7000: conformance/*.bin, written from SwRI's
// keyence_experimental and a protocol dissector that agree, [V] Keyence's tables of the communication
// protocol and its C samples of 2014, [H] notes of a lab with an LJ-V7200.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/options/number.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/laser_profiler/ljv.h"
#include "files/text_file.h"
#include "plant/twins/laser_profiler.h"
#include "tests/plant/ice_bench.h"

using namespace firn;
using namespace firn::drivers;

namespace {

const std::string kFolder = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/conformance/";

/// "20 00 FF" as bytes.
std::string hex_bytes(const char* hex) {
  std::istringstream in(hex);
  std::string bytes, word;
  while (in >> word) bytes += char(hex_byte(word).value());
  return bytes;
}

lkg::Reply reply_of(std::string_view command, std::string_view line) { return lkg::parse(line, command); }

}  // namespace

TEST_CASE("the LK-G codec reads the lines of other code bases", "[conformance]") {
  using Kind = lkg::Reply::Kind;
  struct Case {
    const char* source;
    std::string_view command, line;
    Kind kind;
    int error;
    std::string_view rest;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"[I] in measuring mode already", "R0", "ER,R0,01", Kind::kError, 1, ""},
           {"[I] to communication mode", "Q0", "Q0", Kind::kDone, 0, ""},
           {"[I] in communication mode already", "Q0", "ER,Q0,01", Kind::kError, 1, ""},
           {"[I] nothing is measured in communication mode", "M1", "ER,M1,01", Kind::kError, 1, ""},
           {"[I] nor both outputs", "M0", "ER,M0,01", Kind::kError, 1, ""},
           {"[I] output 1", "M1", "M1,+00.1234", Kind::kDone, 0, "+00.1234"},
           {"[I] output 2", "M2", "M2,-02.3122", Kind::kDone, 0, "-02.3122"},
           {"[I] both outputs", "M0", "M0,+00.1234,-02.3122", Kind::kDone, 0, "+00.1234,-02.3122"},
           {"[I] reset", "VR,1", "VR", Kind::kDone, 0, ""},
           {"[I] both reset", "VR,0", "VR", Kind::kDone, 0, ""},
           {"[I] a setting is echoed without its arguments", "SW,HB,1,4", "SW,HB", Kind::kDone, 0, ""},
           {"[I] and read back with its value", "SR,HB,1", "SR,HB,1,4", Kind::kDone, 0, "1,4"},
           {"[I] a value without a point", "SW,OF,1,+123423", "SW,OF", Kind::kDone, 0, ""},
           {"[I] read back with its point", "SR,OF,1", "SR,OF,1,+12.3423", Kind::kDone, 0, "1,+12.3423"},
           {"[I] an error names the identifier, not SW", "SW,OF,1,x", "ER,OF,00", Kind::kError, 0, ""},
           {"[I] nor SR", "SR,HB,1", "ER,HB,01", Kind::kError, 1, ""},
           {"the command is accepted too", "SR,HB,1", "ER,SR,01", Kind::kError, 1, ""},
           {"of another setting", "SR,HB,1", "ER,OF,01", Kind::kForeign, 0, ""}}) {
    INFO(c.source << ": " << c.command << " -> " << c.line);
    const lkg::Reply r = reply_of(c.command, c.line);
    CHECK(r.kind == c.kind);
    CHECK(r.error == c.error);
    CHECK(r.rest == c.rest);
  }
  CHECK(lkg::parse_value("+00.1234").mm == 0.1234);
  CHECK(lkg::parse_value("-02.3122").mm == -2.3122);
}

TEST_CASE("a dump of an LK-G5000 has no number of its output and values of nine characters",
          "[conformance]") {  // [L]
  constexpr std::size_t kChars = 9;
  std::vector<float> mm;
  const lkg::Reply r = reply_of("AO,01", "AO,+00012.34,-00000.50,-FFFFFFF,+FFFFFFF");
  REQUIRE(r.kind == lkg::Reply::Kind::kDone);
  REQUIRE(lkg::parse_dump(r.rest, mm, kChars) == 0);
  REQUIRE(mm.size() == 4);
  CHECK(mm[0] == Approx(12.34f));
  CHECK(mm[1] == Approx(-0.5f));
  CHECK(std::isnan(mm[2]));
  CHECK(std::isnan(mm[3]));
  CHECK_FALSE(lkg::parse_dump(r.rest, mm));             // an LK-G3001P has eight
  CHECK(lkg::parse_dump("+00.1234", mm, kChars) == 1);  // a byte is missing: no value, and counted
}

TEST_CASE("the point laser's twin answers as the emulator of a line in use", "[conformance]") {  // [I]
  plant::IceBench b{plant::small()};
  for (const auto& [sent, reply] :
       std::initializer_list<std::pair<const char*, const char*>>{{"R0", "ER,R0,01\r"},
                                                                  {"SR,HB,1", "ER,HB,01\r"},
                                                                  {"VR,1", "VR\r"},
                                                                  {"VR,0", "VR\r"},
                                                                  {"Q0", "Q0\r"},
                                                                  {"Q0", "ER,Q0,01\r"},
                                                                  {"M1", "ER,M1,01\r"},
                                                                  {"M0", "ER,M0,01\r"},
                                                                  {"SW,HB,1,4", "SW,HB\r"},
                                                                  {"SR,HB,1", "SR,HB,1,4\r"},
                                                                  {"SW,OF,1,+123423", "SW,OF\r"},
                                                                  {"SR,OF,1", "SR,OF,1,+12.3423\r"},
                                                                  {"SW,OF,1,x", "ER,OF,22\r"},
                                                                  {"R0", "R0\r"}}) {
    INFO(sent);
    CHECK(b.laser(sent) == reply);
  }
  const std::string one = b.laser("M1"), both = b.laser("M0");
  CHECK(one.substr(0, 3) == "M1,");
  CHECK(both.size() == std::string("M0,+00.1234,-02.3122\r").size());
  CHECK(std::isfinite(lkg::parse_value(both.substr(3, 8)).mm) ==
        std::isfinite(lkg::parse_value(one.substr(3, 8)).mm));
}

TEST_CASE("the eight golden replies of an LJ-V7000 hold the values that are written beside them",
          "[conformance]") {
  std::ifstream values(kFolder + "ljv_values.txt");
  std::string line;
  int profiles = 0;
  ljv::RawProfile raw;
  while (std::getline(values, line)) {
    if (line.starts_with("#")) continue;
    std::istringstream words(line);
    std::string name;
    int k = 0, unit = 0;
    REQUIRE(words >> name >> k >> unit);
    INFO(name << ", profile " << k);
    const std::string reply = read_file(kFolder + name + ".bin");
    const auto bytes = std::as_bytes(std::span(reply.data(), reply.size()));
    const Request asked = ljv::get_newest_profile();
    const Frame frame = ljv::LjvDialect().frame(bytes, &asked);
    CHECK(frame.kind == Frame::Kind::kReply);
    CHECK(frame.size == reply.size());
    for (std::size_t cut = 4; cut < std::min<std::size_t>(reply.size(), 200); ++cut)
      CHECK(ljv::LjvDialect().frame(bytes.first(cut), &asked).kind == Frame::Kind::kIncomplete);
    const auto held = ljv::parse_holdings(bytes);
    REQUIRE(held);
    CHECK(held->newest == 100);
    CHECK(held->oldest == 1);
    REQUIRE(ljv::parse_profile(bytes, raw, k));
    std::size_t n = 0;
    for (std::int32_t v = 0; words >> v; ++n) {
      REQUIRE(n < raw.z_mm.size());
      if (v >= -524288 && v <= -524285)
        CHECK(std::isnan(raw.z_mm[n]));
      else
        CHECK(double(raw.z_mm[n]) == Approx(v * unit * 1e-5).margin(1e-12));
    }
    CHECK(n == std::size_t(raw.points));
    CHECK(held->profiles == (n == 0 ? 0 : name == "two_profiles" ? 2 : 1));
    if (n == 0) continue;
    ++profiles;
    CHECK(raw.trigger_count == std::uint32_t(7 + k));
    CHECK(raw.encoder_count == -12345 + k);
    CHECK(raw.x0_mm == Approx(-4.0));
    CHECK(raw.dx_mm == Approx(0.01));
    if (k + 1 == held->profiles) CHECK_FALSE((ljv::parse_profile(bytes, raw, k + 1) && raw.points > 0));
  }
  CHECK(profiles == 8);
}

TEST_CASE("a reply whose profiles do not fit into its bytes has none that could be read", "[conformance]") {
  std::string reply = read_file(kFolder + "two_profiles.bin");
  const auto bytes = std::as_bytes(std::span(reply.data(), reply.size()));
  reply[28 + 12] = char(200);  // profiles
  CHECK_FALSE(ljv::parse_holdings(bytes));
  ljv::RawProfile raw;
  for (int k = 2; k < 200; ++k) CHECK_FALSE(ljv::parse_profile(bytes, raw, k));
}

TEST_CASE("requests to an LJ-V7000 are those of its maker's samples and of a lab with an LJ-V7200",
          "[conformance]") {
  const auto sent = [](const Request& r) { return std::string(r.text()); };
  CHECK(sent(ljv::get_newest_profile()) ==
        hex_bytes("20 00 00 00 01 00 F0 00 00 00 00 00 14 00 00 00 42 00 "
                  "00 00 00 00 00 00 00 00 00 00 01 00 00 00 01 01 00 00"));
  CHECK(sent(ljv::change_program(5)) ==
        hex_bytes("14 00 00 00 01 00 F0 00 00 00 00 00 08 00 00 00 39 00 00 00 05 00 00 00"));
}

TEST_CASE("the LJ-V codec reads refusals, missing profiles and error lists as its maker's tables have them",
          "[conformance]") {
  struct Case {
    const char* source;
    std::uint8_t command;
    const char* reply;
    std::uint8_t return_code;
    std::string_view says;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"[V] a frame with a wrong fixed value", ljv::kGetProfile,
            "0C 00 00 00 01 00 00 F0 21 00 00 00 00 00 00 00", 0x21, "a fixed value of the frame is wrong"},
           {"[V] a frame that did not end", ljv::kChangeProgram,
            "0C 00 00 00 01 00 00 F0 11 00 00 00 00 00 00 00", 0x11, "the frame did not end in time"},
           {"[V] no profile yet", ljv::kGetProfile,
            "18 00 00 00 01 00 00 F0 00 00 00 00 0C 00 00 00 42 A0 00 00 00 00 00 00 03 00 00 00",
            ljv::kNoProfile, "no profile was measured yet"},
           {"[V] advanced mode", ljv::kGetProfile,
            "18 00 00 00 01 00 00 F0 00 00 00 00 0C 00 00 00 42 80 00 00 00 00 00 00 03 00 00 00", 0x80,
            "it is in advanced mode; high-speed mode is needed"},
           {"[V] programs by terminal", ljv::kChangeProgram,
            "18 00 00 00 01 00 00 F0 00 00 00 00 0C 00 00 00 39 80 00 00 00 00 00 00 03 00 00 00", 0x80,
            "its terminals switch the program"}}) {
    INFO(c.source);
    const std::string reply = hex_bytes(c.reply);
    const auto bytes = std::as_bytes(std::span(reply));
    const Request asked = c.command == ljv::kGetProfile ? ljv::get_newest_profile() : ljv::change_program(3);
    for (std::size_t cut = 4; cut < bytes.size(); ++cut)
      CHECK(ljv::LjvDialect().frame(bytes.first(cut), &asked).kind == Frame::Kind::kIncomplete);
    const Frame frame = ljv::LjvDialect().frame(bytes, &asked);
    CHECK(frame.kind == Frame::Kind::kReply);
    CHECK(frame.size == reply.size());
    const auto head = ljv::parse_head(bytes);
    REQUIRE(head);
    CHECK(head->return_code == c.return_code);
    CHECK(ljv::return_text(c.command, head->return_code) == c.says);
  }
  const Request asked = ljv::get_newest_profile();
  const auto kind = [&](const char* reply) {
    const std::string text = hex_bytes(reply);
    return ljv::LjvDialect().frame(std::as_bytes(std::span(text)), &asked).kind;
  };
  CHECK(kind("0C 00 00 00 01 00 00 F0 00 00 00 00 00 00 00 00") ==
        Frame::Kind::kCorrupt);  // no refusal, no answer
  CHECK(kind("0C 00 00 00 01 00 00 F0 21 00 00 00 04 00 00 00") == Frame::Kind::kCorrupt);
  const auto errors = [](const char* reply) {
    const std::string text = hex_bytes(reply);
    return ljv::error_text(std::as_bytes(std::span(text)));
  };
  CHECK(errors("1C 00 00 00 01 00 00 F0 00 00 00 00 10 00 00 00 04 00 00 00 00 00 00 00 03 00 00 00 00 7F 7F "
               "7F") == "no error");
  CHECK(errors("20 00 00 00 01 00 00 F0 00 00 00 00 14 00 00 00 04 00 00 00 00 00 00 00 03 00 00 00 01 00 00 "
               "00 84 00 00 00") == "errors 0084");
  CHECK(errors("20 00 00 00 01 00 00 F0 00 00 00 00 14 00 00 00 04 00 00 00 00 00 00 00 03 00 00 00 02 00 00 "
               "00 84 00 10 20") == "errors 0084 2010");
  CHECK(errors("20 00 00 00 01 00 00 F0 00 00 00 00 14 00 00 00 04 00 00 00 00 00 00 00 03 00 00 00 FF 00 00 "
               "00 84 00 00 00") == "errors 0084 0000");  // as many as are there
}
