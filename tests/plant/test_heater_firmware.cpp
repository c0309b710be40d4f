// The heaters' firmware against the twin that is written from docs/devices/heater.md: the same lines, whole
// and damaged.
#include <catch2/catch.hpp>

#include <random>

#include "drivers/heater/thermostat.h"
#include "firmware/heater/heater.h"
#include "plant/twins/firmware_heater.h"
#include "plant/twins/lines.h"
#include "tests/plant/ice_bench.h"

using namespace firn;
using namespace firn::plant;
namespace thermostat = firn::drivers::thermostat;

namespace {

constexpr double kHysteresis_degC = 1.0;

class HeaterPair {
 public:
  explicit HeaterPair(std::uint32_t seed) : random_(seed), plain_(of(false)), firmware_(of(true)) {
    for (IceBench* b : both()) b->run(1'000'000);
  }
  void run(int lines) {
    for (; asked < lines && different.empty(); ++asked) turn();
  }
  std::string different;
  int asked = 0, readings = 0, refused = 0, damaged = 0;
  double farthest_degC = 0.0;

 private:
  static IceWorldConfig of(bool firmware) {
    IceWorldConfig c = small();
    c.heater_firmware = firmware;
    return c;
  }
  std::array<IceBench*, 2> both() { return {&plain_, &firmware_}; }
  int roll(int below) { return int(random_() % std::uint32_t(below)); }

  std::string command() {
    switch (roll(10)) {
      case 0:
      case 1:
        return "S," + std::to_string(roll(5)) + ',' + std::to_string(roll(11000) - 5500);
      case 2: {
        const int channel = 1 + roll(3);
        set_degC_[std::size_t(channel - 1)] = roll(60) * 0.5 + 5.0;
        return "S," + std::to_string(channel) + ',' +
               std::to_string(std::lround(set_degC_[std::size_t(channel - 1)] * 100.0));
      }
      case 3: {
        static const char* const kOdd[] = {"",          "T",         "T??",
                                           "S",         "S,",        "S,1",
                                           "S,1,",      "S,1,-",     "S,+1,+20",
                                           "S,01,007",  "S,1,2,3",   "S,1 2000",
                                           "S,1,2e3",   "S,,2000",   "s,1,2000",
                                           "S,4,0",     "S,1,4500",  "S,1,4501",
                                           "S,1,-5000", "S,1,-5001", "S,1,99999999999999999999",
                                           "S,1,-0"};
        return kOdd[roll(int(std::size(kOdd)))];
      }
      default:
        return "T?";
    }
  }

  void turn() {
    const std::string text = command();
    std::string line = sealed(text);
    if (roll(12) == 0) line[std::size_t(roll(int(line.size())))] ^= char(1 << roll(7));
    if (roll(30) == 0) line.insert(0, std::string(std::size_t(roll(70)), 'x'));
    if (roll(30) == 0) line.erase(std::size_t(roll(int(line.size()))), 1);
    if (line.find('\n') == line.npos) line += '\n';
    std::array<std::string, 2> said;
    for (std::size_t n = 0; n < 2; ++n) {
      IceBench& b = *both()[n];
      b.heard["heater"].clear();
      b.send("heater", std::as_bytes(std::span(line.data(), line.size())));
      b.run(400'000);
      said[n] = b.heard["heater"];
    }
    compare(line, said);
    if (roll(20) == 0)
      for (IceBench* b : both()) b->run(30'000'000);
  }

  void compare(const std::string& line, const std::array<std::string, 2>& said) {
    refused += said[0].starts_with("E,2") || said[0].starts_with("E,3");
    damaged += said[0].starts_with("E,1");
    if (said[0].starts_with("T,") && said[1].starts_with("T,")) return compare_readings(said);
    if (said[0] != said[1]) different = "'" + line + "': '" + said[0] + "' and '" + said[1] + "'";
  }

  /// The converters round to 0.25 degC, so that a thermostat switches a little earlier or later.
  void compare_readings(const std::array<std::string, 2>& said) {
    std::array<std::optional<thermostat::Reading>, 2> r;
    for (std::size_t n = 0; n < 2; ++n)
      if (const auto text = unsealed(said[n])) r[n] = thermostat::parse_reading(*text);
    if (!r[0] || !r[1]) {
      different = "readings '" + said[0] + "' and '" + said[1] + "'";
      return;
    }
    ++readings;
    for (std::size_t c = 0; c < 3; ++c)
      farthest_degC = std::max(farthest_degC, std::abs(r[0]->celsius[c] - r[1]->celsius[c]));
  }

  std::mt19937 random_;
  IceBench plain_, firmware_;
  std::array<double, 3> set_degC_{20.0, 22.0, 20.0};
};

}  // namespace

TEST_CASE(
    "the heaters' firmware answers every line as the twin of its page does, and its heaters go with the "
    "twin's") {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    HeaterPair pair(seed);
    pair.run(400);
    INFO("seed " << seed << ": " << pair.different);
    CHECK(pair.different.empty());
    CHECK(pair.asked == 400);
    CHECK(pair.readings > 100);
    CHECK(pair.refused > 20);
    CHECK(pair.damaged > 20);
    CHECK(pair.farthest_degC <
          2.0 * kHysteresis_degC + 0.5);  // one is on where the other is off, at the worst
  }
}

TEST_CASE("the heaters' firmware shows each word of a MAX31855 as its data sheet has it") {
  ::heater h{};
  heater_init(&h, HEATER_HIGHEST_CDEGC);
  const auto shown = [&](std::uint32_t word) {
    heater_read(&h, 0, word);
    return h.channel[0].open ? -99999 : h.channel[0].shown_cdegC;
  };
  CHECK(shown(0x06400000) == 10000);  // the data sheet's rows: 100.75 is 0000 0110 0100 11
  CHECK(shown(0x064C0000) == 10075);
  CHECK(shown(0x01900000) == 2500);
  CHECK(shown(0x00000000) == 0);
  CHECK(shown(0xFFFC0000) == -25);
  CHECK(shown(0xFFF00000) == -100);
  for (const std::uint32_t bad :
       {0x00010001u, 0x01910002u, 0x01910004u, 0xFFFFFFFFu, 0x64000000u, 0xF0600000u})
    CHECK(shown(bad) == -99999);
  for (int quarter = -400; quarter <= 1600; ++quarter)
    CHECK(shown(converted(quarter * 0.25)) == quarter * 25);
}

TEST_CASE(
    "the heaters' firmware switches off what it cannot trust, and what is too hot until it is set anew") {
  ::heater h{};
  heater_init(&h, HEATER_HIGHEST_CDEGC);
  REQUIRE(heater_restore(&h, 1, 2000));
  CHECK_FALSE(heater_restore(&h, 1, HEATER_HIGHEST_CDEGC + 1));
  CHECK_FALSE(heater_restore(&h, 3, 2000));
  const auto tick = [&](double degC) {
    heater_read(&h, 1, converted(degC));
    heater_tick(&h);
    return h.channel[1].relay;
  };
  const auto say = [&](const std::string& text) {
    for (const char c : sealed(text)) heater_receive(&h, std::uint8_t(c));
    return std::string(reinterpret_cast<const char*>(h.reply), h.reply_size);
  };
  heater_tick(&h);
  CHECK_FALSE(h.channel[1].relay);  // nothing was read yet
  CHECK(tick(19.0));
  CHECK(tick(20.75));
  CHECK_FALSE(tick(21.0));
  CHECK_FALSE(tick(19.25));
  CHECK(tick(19.0));
  CHECK_FALSE(tick(std::nan("")));
  CHECK(say("T?") == sealed("T,OPEN,OPEN,OPEN,0"));
  CHECK(tick(10.0));
  CHECK(say("T?") == sealed("T,OPEN,1000,OPEN,2"));
  for (int n = 1; n < HEATER_STALE_TICKS; ++n) heater_tick(&h);
  CHECK(h.channel[1].relay);
  heater_tick(&h);  // its converter has said nothing for two seconds
  CHECK_FALSE(h.channel[1].relay);
  CHECK_FALSE(tick(50.25));
  CHECK_FALSE(tick(10.0));  // cut out
  CHECK(say("S,2,2000") == sealed("S,2,2000"));
  CHECK(tick(10.0));
  CHECK(say("S,2,-5000") == sealed("S,2,-5000"));
  CHECK_FALSE(tick(-60.0));
}
