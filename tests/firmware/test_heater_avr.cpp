// The heaters' binary for the ATmega2560, in simavr: lines of its host, words of three MAX31855, relays.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <random>

#include "firmware/heater/heater.h"
#include "plant/twins/firmware_heater.h"
#include "plant/twins/lines.h"
#include "tests/firmware/avr_mcu.h"

using namespace firn;
using firn::plant::converted;
using firn::plant::sealed;
using firn::test::AvrMcu;

namespace {

constexpr int kBaud = 9600;
constexpr double kTick_us = double(HEATER_TICK_MS) * 1000.0;

/// The binary with its converters, relays and host.
struct Box {
  explicit Box(std::vector<std::uint8_t> eeprom = {}) : avr(FIRN_HEATER_ELF, std::move(eeprom), kBaud) {
    for (int n = 0; n < HEATER_CHANNELS; ++n) {
      avr.watch('A', n, [this, n](bool high) {
        if (high) return;
        selected = n;
        at_byte = 0;
      });
      avr.watch('C', n, [this, n](bool high) { relay[std::size_t(n)] = high; });
    }
    avr.on_spi([this](std::uint8_t) {
      constexpr int kLast = 3;
      return std::uint8_t(word[std::size_t(selected)] >> 8 * (kLast - at_byte++ % 4));
    });
    run(3);
  }
  void run(double ticks) { avr.run_us(ticks * kTick_us); }
  void warm(double a, double b, double c) { word = {converted(a), converted(b), converted(c)}; }
  std::string raw(const std::string& line) {
    avr.take_sent();
    avr.send(std::as_bytes(std::span(line.data(), line.size())));
    avr.run_us(150'000);
    return avr.take_sent();
  }
  std::string say(const std::string& text) { return raw(sealed(text)); }

  std::array<std::uint32_t, 3> word{converted(20.0), converted(20.0), converted(20.0)};
  std::array<bool, 3> relay{};
  int selected = 0, at_byte = 0;
  AvrMcu avr;
};

}  // namespace

TEST_CASE("the heaters' binary reads its converters, holds its set points and says both") {
  Box box;
  CHECK(box.say("T?") == sealed("T,2000,2000,2000,0"));  // no set point: off
  CHECK(box.say("S,1,2500") == sealed("S,1,2500"));
  CHECK(box.say("S,3,-1000") == sealed("S,3,-1000"));
  box.run(2);
  CHECK(box.relay == std::array{true, false, false});
  box.warm(25.75, -0.25, -11.25);
  box.run(2);
  CHECK(box.say("T?") == sealed("T,2575,-25,-1125,5"));
  box.warm(26.0, -0.25, std::nan(""));
  box.run(2);
  CHECK(box.say("T?") == sealed("T,2600,-25,OPEN,0"));
  CHECK(box.relay == std::array{false, false, false});
  box.word = {0xFFFFFFFF, converted(0.0), 0xFFFFFFFF};  // converters that are not there
  box.run(2);
  CHECK(box.say("T?") == sealed("T,OPEN,0,OPEN,0"));
}

TEST_CASE("the heaters' binary answers every line as the host's build of its core does") {
  Box box;
  ::heater core{};
  heater_init(&core, HEATER_HIGHEST_CDEGC);
  std::mt19937 random(7);
  const auto roll = [&](int below) { return int(random() % std::uint32_t(below)); };
  int refused = 0;
  for (int n = 0; n < 60; ++n) {
    for (std::uint32_t& w : box.word)
      w = roll(9) == 0 ? std::uint32_t(random()) : converted(roll(400) * 0.25 - 20.0);
    box.run(2);
    for (int c = 0; c < HEATER_CHANNELS; ++c) heater_read(&core, std::uint8_t(c), box.word[std::size_t(c)]);
    heater_tick(&core);
    std::string line =
        roll(2) == 0 ? sealed("T?")
                     : sealed("S," + std::to_string(1 + roll(4)) + ',' + std::to_string(roll(11000) - 5500));
    if (roll(6) == 0) line[std::size_t(roll(int(line.size() - 1)))] ^= char(1 << roll(3));
    if (roll(12) == 0) line.insert(0, std::string(80, 'x'));
    if (line.find('\n') == line.npos) continue;
    std::string expected;
    for (const char b : line) {
      heater_receive(&core, std::uint8_t(b));
      expected.append(reinterpret_cast<const char*>(core.reply), core.reply_size);
    }
    INFO("line " << n << ": '" << line << "'");
    CHECK(box.raw(line) == expected);
    refused += expected.find('E') != expected.npos;
    heater_tick(&core);
    box.run(2);
    for (std::size_t c = 0; c < 3; ++c) CHECK(box.relay[c] == core.channel[c].relay);
  }
  CHECK(refused > 5);
}

TEST_CASE(
    "a heaters' processor that hangs is reset: relays off at once, then on again by the kept set points") {
  Box box;
  box.warm(10.0, 10.0, 10.0);
  CHECK(box.say("S,2,2200") == sealed("S,2,2200"));
  box.run(2);
  REQUIRE(box.relay == std::array{false, true, false});
  int offs = 0;
  box.avr.watch('C', 1, [&](bool high) { offs += !high; });
  box.avr.hang();
  box.run(10);
  CHECK(offs >= 1);
  CHECK(box.relay == std::array{false, true, false});
  Box again(box.avr.eeprom());  // a power cycle
  again.warm(10.0, 10.0, 10.0);
  again.run(3);
  CHECK(again.relay == std::array{false, true, false});
  Box erased(std::vector<std::uint8_t>(4096, 0xFF));
  erased.warm(-60.0, -60.0, -60.0);
  erased.run(3);
  CHECK(erased.relay == std::array{false, false, false});
}

TEST_CASE("noise on its line leaves the heaters' binary answering, within its memory") {
  Box box;
  std::mt19937 random(5);
  for (int n = 0; n < 10; ++n) {
    std::string noise(1 + random() % 300, '\0');
    for (char& c : noise) c = char(random() % 60 == 0 ? '\n' : random() % 256);
    box.raw(noise);
    box.raw("\n");
    box.run(5);  // its answers go out
    CHECK(box.say("T?") == sealed("T,2000,2000,2000,0"));
  }
  constexpr std::uint32_t kRam = 8192;
  CHECK(box.avr.static_bytes() + box.avr.deepest_stack() <= kRam / 4);
  constexpr std::uint64_t kTickOfTimer = 25'000 * AvrMcu::kCyclesOfAUs;
  CHECK(box.avr.longest_interrupt() < kTickOfTimer / 100);
  WARN("RAM " << box.avr.static_bytes() << " bytes and " << box.avr.deepest_stack()
              << " of stack; longest interrupt " << box.avr.longest_interrupt() << " cycles");
}
