// Lines as firmwares and serial servers send them: other line ends, padding, echoes, Telnet's negotiation.
// Captured lines have their source beside them: [AL] GraysonBellamy/alicatlib 78bd03a8,
// its fixtures of responses (captures of 2026-04-17), [NA] numat/alicat e42e52e8; the letters of the other
// instruments are those of conformance_test.cpp and conformance_lines_test.cpp.
#include <catch2/catch.hpp>
#include <map>

#include "drivers/gas/gas.h"
#include "drivers/heater/thermostat.h"
#include "drivers/jet/jetdrive.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/link/link.h"
#include "drivers/stage/ensemble.h"
#include "tests/drivers/ice_rig.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using Catch::Contains;
using firn::drivers::test::bytes_of;
using firn::drivers::test::IceRig;
using firn::drivers::test::next;
using firn::drivers::test::WorldRig;
using namespace std::string_literals;
using namespace std::string_view_literals;

namespace {

/// The way from an instrument to the host.
enum class Custom { kPlain, kCrLf, kLf, kNulsAround, kBlanks, kTelnet, kEcho };
constexpr Custom kCustoms[] = {Custom::kPlain,  Custom::kCrLf,   Custom::kLf,  Custom::kNulsAround,
                               Custom::kBlanks, Custom::kTelnet, Custom::kEcho};

class ForeignLine {
 public:
  explicit ForeignLine(Custom custom) : custom_(custom) {}

  void asked(std::string_view bytes) {
    if (custom_ == Custom::kEcho) echo_ += bytes;
  }
  std::string told(std::string_view bytes) {
    std::string out = std::exchange(echo_, {});
    if (custom_ == Custom::kTelnet && !std::exchange(begun_, true))
      out += "\xff\xfd\x2c\xff\xfb\x00\xff\xfa\x2c\x01\x00\x00\x4b\x00\xff\xf0"sv;
    std::string line;
    for (const char c : bytes) {
      if (c != '\r' && c != '\n') {
        line += c;
      } else if (!line.empty()) {
        out += finished(line, c);
        line.clear();
      } else if (custom_ == Custom::kPlain) {
        out += c;
      }
    }
    return out + line;
  }

 private:
  std::string finished(const std::string& line, char end) const {
    switch (custom_) {
      case Custom::kCrLf:
        return line + "\r\n";
      case Custom::kLf:
        return line + "\n";
      case Custom::kNulsAround:
        return "\0\0"s + line + "\0"s + end + "\0"s;
      case Custom::kBlanks:
        return "  " + line + end;
      case Custom::kTelnet:
        return line + "\r\0"s;  // RFC 854: a CR alone has a NUL behind it
      default:
        return line + end;
    }
  }

  Custom custom_;
  bool begun_ = false;
  std::string echo_;
};

/// A rig whose text instruments are behind such lines.
template <class Rig>
class Behind : public Rig {
 public:
  template <class... Args>
  explicit Behind(Custom custom, Args&&... args) : Rig(std::forward<Args>(args)...), custom_(custom) {}

 protected:
  std::string to_instrument(std::string_view name, std::string bytes) override {
    if (has_lines(name)) line(name).asked(bytes);
    return bytes;
  }
  std::string to_host(std::string_view name, std::string bytes) override {
    return has_lines(name) ? line(name).told(bytes) : bytes;
  }

 private:
  static bool has_lines(std::string_view name) {
    return name == "stage" || name == "lamp" || name == "robot" || name == "laser_point" || name == "heater";
  }
  ForeignLine& line(std::string_view name) {
    return lines_.try_emplace(std::string(name), custom_).first->second;
  }

  Custom custom_;
  std::map<std::string, ForeignLine> lines_;
};

std::string in_pieces(std::string_view heard, char end, std::uint64_t& seed) {
  LineCleaner cleaner;
  std::vector<std::byte> out;
  while (!heard.empty()) {
    const std::size_t n = std::min<std::size_t>(1 + next(seed) % 4, heard.size());
    cleaner.clean(bytes_of(heard.substr(0, n)), end, out);
    heard.remove_prefix(n);
  }
  return {reinterpret_cast<const char*>(out.data()), out.size()};
}

}  // namespace

TEST_CASE("line ends of either convention, blank lines, padding and Telnet's commands leave the line alone",
          "[link]") {
  for (const std::string_view heard : {"A +1 N2\r"sv, "A +1 N2\r\n"sv, "A +1 N2\n"sv, "\n\r\nA +1 N2\r"sv,
                                       "\0\0A +1 N2\0\r\0"sv, "  A +1 N2\r"sv, "A \0+1 \b\bN2\r"sv,
                                       "\xff\xfd\x2c\xff\xfb\x00"
                                       "A +1 N2\r\0"sv,
                                       "\xff\xfa\x2c\x01\xff\xf0"
                                       "A +1 N2\r"sv})
    CHECK(cleaned(heard, '\r') == "A +1 N2\r");
  CHECK(cleaned("%5\r\n%6\r\n", '\n') == "%5\n%6\n");
}

TEST_CASE("a byte that damage has made within a word stays, so that the word is no number", "[link]") {
  CHECK(cleaned("A +1\0.5\r"sv, '\r') == "A +1\0.5\r"sv);
  CHECK(cleaned("A +1\b.5\r"sv, '\r') == "A +1\b.5\r"sv);
  CHECK(cleaned("A +1\xff.5\r"sv, '\r') == "A +1\xff.5\r"sv);
  CHECK(cleaned("A +1\x10.5\r"sv, '\r') == "A +1\x10.5\r"sv);
}

TEST_CASE("however a stream is cut, its lines are the same", "[link]") {
  std::uint64_t seed = 5;
  constexpr char kBytes[] = {'\r', '\n', '\0', ' ', '\b', 'A', '+', '1', '\xff', '\xfb', '\xfa', '\xf0'};
  for (int round = 0; round < 2000; ++round) {
    std::string heard;
    for (std::size_t n = next(seed) % 30; n > 0; --n) heard += kBytes[next(seed) % std::size(kBytes)];
    const char end = next(seed) % 2 ? '\r' : '\n';
    const std::string whole = cleaned(heard, end);
    CHECK(in_pieces(heard, end, seed) == whole);
    CHECK(cleaned(whole, end).size() <= whole.size());
    CHECK(whole.find("\r\r") == std::string::npos);
  }
}

TEST_CASE(
    "every instrument with lines becomes safe whatever line ends, padding, echo or serial server it has",
    "[link]") {
  for (const Custom custom : kCustoms) {
    CAPTURE(int(custom));
    Behind<WorldRig> inkjet(custom, WorldRig::small_world(4, 4));
    inkjet.start();
    CHECK(inkjet.all_safe());
    Behind<IceRig> ice(custom);
    ice.start();
    CHECK(ice.all_safe());
    ice.act("laser_point", [&](std::int64_t t, Effects& fx) { ice.laser.arm(0, 10, 0.01, t, fx); });
    CHECK(ice.run([&] { return !ice.laser.busy(); }, 30.0));
    CHECK(ice.driver("laser_point").state() == DeviceState::kArmed);
  }
}

TEST_CASE("a poll of each Alicat firmware that was captured is read by place", "[gas][conformance]") {
  struct Captured {
    const char* line;
    double kpsi, set_point, resolution;
    const char* gas;
    std::uint16_t codes;
  };
  const Captured captured[] = {
      {"A +014.52 +021.50 +0000.1 +0000.2 0116.3      N2", 14.52, 116.3, 0.1, "N2", 0},   // [AL] 5v12.0-R22
      {"B +014.62 +022.95 +000.00 +000.00 +000.00     N2", 14.62, 0.0, 0.01, "N2", 0},    // [AL] 8v17.0-R23
      {"A +014.62 +021.89 +000.00 +000.00 +078.95     N2", 14.62, 78.95, 0.01, "N2", 0},  // [AL] 10v20.0-R24
      {"A +14.70 +25.0 +45.0 +45.0 +75.0 N2", 14.70, 75.0, 0.1, "N2", 0},                 // [AL] before 9v00
      // [AL] ??D* of 10v20: codes ADC OPL POV P2O TOV VOV MOV TMF OVR COM HLD EXH GTA LCK may follow the gas
      {"A +014.70 +025.00 +050.00 +050.00 +050.00 Air MOV HLD", 14.70, 50.0, 0.01, "Air",
       alicat::kMassOver | alicat::kHold},
      {"A +014.70 +025.00 +000.00 +000.00 +000.00 N2 GTA LCK", 14.70, 0.0, 0.01, "N2", alicat::kLocked},
      // [NA] get(): the total of a unit with a totaliser is behind the set point
      {"A +014.70 +025.00 +012.00 +012.00 +012.00 +0021513.0 N2 TOV", 14.70, 12.0, 0.01, "N2",
       alicat::kTemperatureOver},
      {"A +014.70 +025.00 +012.00 +012.00 012.00 0021513 00000.1 C-25", 14.70, 12.0, 0.01, "C-25", 0},
      {"A 014.70 025.00 000.00 000.00 012.00 Ar", 14.70, 12.0, 0.01, "Ar", 0},
  };
  for (const Captured& c : captured) {
    INFO(c.line);
    const auto r = alicat::parse_reading(c.line);
    REQUIRE(r);
    CHECK(r->unit == c.line[0]);
    CHECK(r->pressure == c.kpsi);
    CHECK(r->set_point == c.set_point);
    CHECK(r->resolution == Approx(c.resolution));
    CHECK(r->gas == c.gas);
    CHECK(r->codes == c.codes);
  }
  // [AL] 10v04.0-R24, a meter: no set point, so it controls nothing.
  CHECK_FALSE(alicat::parse_reading("A +14.633 +022.97 -00.034 -00.034    Air"));
}

TEST_CASE("no flipped bit of a data frame moves a number to another place", "[gas]") {
  for (const std::string frame :
       {"A +014.52 +021.50 +0000.1 +0000.2 0116.3      N2",
        "A +014.62 +020.09 +010.00 -000.01 +078.95     N2", "A 014.70 025.00 010.00 010.00 012.00 Ar"}) {
    const auto right = alicat::parse_reading(frame);
    REQUIRE(right);
    for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
      std::string damaged = frame;
      damaged[bit / 8] ^= char(1 << bit % 8);
      const std::string line = cleaned(damaged + '\r', '\r');
      const auto r = alicat::parse_reading(std::string_view(line).substr(0, line.find('\r')));
      if (!r) continue;
      INFO(damaged);
      int other = 0;  // one digit, at most, is another one
      for (const auto& [a, b] : {std::pair{r->pressure, right->pressure},
                                 {r->temperature_degC, right->temperature_degC},
                                 {r->volume_flow, right->volume_flow},
                                 {r->mass_flow, right->mass_flow},
                                 {r->set_point, right->set_point}})
        other += a != b;
      CHECK(other <= 1);
    }
  }
}

TEST_CASE("the firmware of each Alicat that was captured is named, or known by its silence",
          "[gas][conformance]") {
  const alicat::AlicatDialect dialect;
  const Request asked = alicat::version_request({'A', false}, GasDialect(), 0);
  for (const char* line : {"A   10v20.0-R24 Jan  9 2025,15:04:07\r",  // [AL]
                           "A   8v17.0-R23 Nov 27 2019,15:28:45\r",   // [AL]
                           "A GP\r"})                                 // [AL]
    CHECK(is_whole_reply(dialect, asked, line));
}

TEST_CASE("an Ensemble's captured answers are read with and without CR", "[conformance]") {
  const ensemble::EnsembleDialect dialect;
  const auto number = [&](std::string_view line) {
    const std::string text = cleaned(line, '\n');
    return dialect.parse(bytes_of(text)).number();
  };
  CHECK(number("%10.000\n") == 10.0);              // [B]
  CHECK(number("%-2147483641\n") == -2147483641);  // [X]
  CHECK(number("%6\r\n") == 6.0);                  // [R]
  CHECK(number("%1000\r\n") == 1000.0);            // [M]
  for (const char* goes_on : {"%10.000mm\n", "%1,5\n", "%0x10\n", "%1e\n", "% 6\n"})
    CHECK_FALSE(number(goes_on));
}

TEST_CASE("values of the LK-G family are read by place, and those that go on are damaged", "[conformance]") {
  for (const auto& [text, chars, mm] : {std::tuple{"+00.1234", 8, 0.1234},     // [I] LK-G3001
                                        std::tuple{"-02.3122", 8, -2.3122},    // [I]
                                        std::tuple{"+00012.34", 9, 12.34}}) {  // [L] LK-G5000
    CHECK(lkg::parse_value(text, std::size_t(chars)).mm == mm);
    CHECK(lkg::parse_value(std::string(text) + "5", std::size_t(chars)).status == lkg::Status::kDamaged);
  }
  CHECK(lkg::parse_value("+00,1234").status == lkg::Status::kDamaged);
  CHECK(lkg::parse_value("+0.1e-02").status == lkg::Status::kDamaged);
}

TEST_CASE("what no dialect understood is kept for the person, with its bytes", "[link]") {
  const alicat::AlicatDialect dialect;
  for (const auto& [heard, shown] : {std::pair{"A +14.633 +022.97 -00.034 -00.034    Air\r"sv,
                                               "'A +14.633 +022.97 -00.034 -00.034    Air'"},
                                     {"A +1\0.5\r"sv, "'A +1\\x00.5'"},
                                     {"\x83\x41"sv, "'\\x83A', which has no end"}}) {
    Link link(dialect);
    Effects fx;
    link.opened(0);
    REQUIRE(link.poll(0, fx)->kind == LinkEvent::Kind::kReady);
    link.push(alicat::poll_request({}, 0));
    CHECK_FALSE(link.poll(0, fx));
    link.received(bytes_of(heard), 1000);
    for (std::int64_t now_us = 1000; now_us < 3'000'000; now_us += 100'000)
      while (link.poll(now_us, fx)) {
      }
    CHECK(link.not_understood() == shown);
  }
}
