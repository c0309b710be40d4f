// The valve's binary for the ATmega2560, in simavr: the same bytes and pins as in the box.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "drivers/valve/fvb.h"
#include "tests/firmware/avr_box.h"

using namespace firn;
using firn::test::AvrBox;
namespace fvb = firn::drivers::fvb;

namespace {

constexpr std::uint64_t kStep = 50 * AvrBox::kCyclesOfAUs;  ///< cycles between two tick interrupts

/// The binary with a host at its serial line.
struct Box {
  explicit Box(std::vector<std::uint8_t> eeprom = {}) : avr(FIRN_VALVE_ELF, std::move(eeprom)) {}

  fvb::Found say(fvb::Type type, std::span<const std::byte> payload = {}) {
    std::vector<std::byte> bytes;
    number = fvb::next_seq(number);
    fvb::encode(type, number, payload, bytes);
    heard = avr.ask(bytes);
    return fvb::find(std::as_bytes(std::span(heard.data(), heard.size())));
  }
  /// 0: acknowledged; -1: no answer.
  int order(fvb::Type type, std::span<const std::byte> payload = {}) {
    const auto reply = fvb::parse_reply(say(type, payload));
    return !reply ? -1 : reply->type == fvb::Type::kAck ? 0 : reply->refusal;
  }
  int head(fvb::Type type, int entries, int tick_us, int pulse_us) {
    std::vector<std::byte> bytes;
    fvb::encode(1, fvb::Begin{7, 1, std::uint16_t(entries), std::uint16_t(tick_us), std::uint16_t(pulse_us)},
                bytes);
    return order(type, std::span(bytes).subspan(fvb::kHead, bytes.size() - fvb::kHead - fvb::kTail));
  }
  int load(const std::vector<std::uint16_t>& ticks, int tick_us, int pulse_us) {
    if (const int why = head(fvb::Type::kBegin, int(ticks.size()), tick_us, pulse_us)) return why;
    for (std::size_t at = 0; at < ticks.size(); at += fvb::kEntriesPerFrame) {
      std::vector<std::byte> bytes;
      fvb::encode_data(1, std::uint16_t(at),
                       std::span(ticks).subspan(at, std::min(fvb::kEntriesPerFrame, ticks.size() - at)),
                       bytes);
      if (const int why = order(fvb::Type::kData,
                                std::span(bytes).subspan(fvb::kHead, bytes.size() - fvb::kHead - fvb::kTail)))
        return why;
    }
    const std::uint16_t crc = fvb::list_crc(ticks);
    const std::byte sum[] = {std::byte(crc & 255), std::byte(crc >> 8)};
    return order(fvb::Type::kEnd, sum);
  }
  int arm() {
    const std::byte for_ever[4] = {};
    return order(fvb::Type::kArm, for_ever);
  }
  fvb::Status status() { return fvb::parse_status(say(fvb::Type::kStatus).payload).value(); }
  fvb::Hello hello() { return fvb::parse_hello(say(fvb::Type::kHello).payload).value(); }

  AvrBox avr;
  std::uint8_t number = 0;
  std::string heard;
};

struct Timing {
  std::size_t pulses = 0;
  std::uint64_t worst_open = 0, worst_length = 0;  ///< cycles off
  bool spikes_first = true;
};

/// Pulses of the hold output against their times, which count from the step at which the list began; spikes
/// begin with them and are 300 us long.
Timing timing_of(const std::vector<AvrBox::Edge>& edges, const std::vector<std::uint16_t>& ticks, int tick_us,
                 int pulse_us) {
  Timing t;
  const auto cycles = [&](std::uint16_t tick) {
    return std::int64_t(tick) * tick_us * std::int64_t(AvrBox::kCyclesOfAUs);
  };
  const auto apart = [](std::int64_t a, std::int64_t b) { return std::uint64_t(a > b ? a - b : b - a); };
  constexpr std::int64_t kHalf = std::int64_t(kStep) / 2, kWhole = std::int64_t(kStep);
  std::int64_t began = 0, opened = 0, spiked = 0;
  for (const AvrBox::Edge& e : edges) {
    const auto at = std::int64_t(e.cycle);
    if (!e.hold) {
      if (e.high) spiked = at;
      t.spikes_first &= e.high || apart(at - spiked, 300 * std::int64_t(AvrBox::kCyclesOfAUs)) <= kStep;
    } else if (e.high) {
      opened = at;
      if (t.pulses == 0) began = at - (cycles(ticks[0]) + kHalf - 1) / kWhole * kWhole;
      if (t.pulses < ticks.size())
        t.worst_open = std::max(t.worst_open, apart(at, began + cycles(ticks[t.pulses])));
      ++t.pulses;
    } else {
      t.worst_length = std::max(
          t.worst_length, apart(at - opened, std::int64_t(pulse_us) * std::int64_t(AvrBox::kCyclesOfAUs)));
    }
  }
  return t;
}

}  // namespace

TEST_CASE("the valve's binary says who it is, what its limits are and how often it has started") {
  Box box;
  const fvb::Hello h = box.hello();
  CHECK(h.firmware == 2);
  CHECK(h.boot_count == 1);
  CHECK(h.max_entries == 3072);
  CHECK(h.step_us == 50);
  CHECK(h.max_pulse_us == 50'000);
  CHECK(h.max_duty_percent == 75);
  std::vector<std::uint8_t> eeprom = box.avr.eeprom();
  for (int n = 2; n < 5; ++n) {  // a power cycle: all but the EEPROM is gone
    Box again(eeprom);
    CHECK(again.hello().boot_count == n);
    CHECK(again.status().state == fvb::State::kIdle);
    eeprom = again.avr.eeprom();
  }
}

TEST_CASE("every edge of the valve's binary is within a tick of its list, while the host asks") {
  // FIRN_AVR_PULSES=1000000: all of it
  const char* wanted = std::getenv("FIRN_AVR_PULSES");
  const std::size_t most = wanted ? std::size_t(std::atoll(wanted)) : 6000;
  std::mt19937 random(3);
  Box box;
  box.hello();
  std::size_t pulses = 0;
  std::uint64_t worst_open = 0, worst_length = 0;
  while (pulses < most) {
    const int tick_us = 700 + int(random() % 150), pulse_us = 500;
    std::vector<std::uint16_t> ticks;
    for (std::uint16_t at = std::uint16_t(random() % 4); ticks.size() < 3072;
         at = std::uint16_t(at + 1 + (random() % 16 == 0)))
      ticks.push_back(at);
    REQUIRE(box.load(ticks, tick_us, pulse_us) == 0);
    REQUIRE(box.arm() == 0);
    box.avr.edges.clear();
    box.avr.trigger();
    while (box.status().state == fvb::State::kFiring) box.avr.run_us(double(random() % 200'000));
    CHECK(box.status().next == ticks.size());
    CHECK(box.status().late_us < 50);
    const Timing t = timing_of(box.avr.edges, ticks, tick_us, pulse_us);
    CHECK(t.pulses == ticks.size());
    CHECK(t.spikes_first);
    worst_open = std::max(worst_open, t.worst_open);
    worst_length = std::max(worst_length, t.worst_length);
    pulses += t.pulses;
  }
  CHECK(worst_open <= kStep);
  CHECK(worst_length <= kStep);
  CHECK(box.avr.longest_interrupt() < kStep);
  CHECK(box.avr.static_bytes() <= 7680);
  CHECK(box.avr.static_bytes() + box.avr.deepest_stack() <= 8192);
  WARN(pulses << " pulses: begin at most " << worst_open << ", length at most " << worst_length
              << " cycles off (a tick is " << kStep << "); longest interrupt " << box.avr.longest_interrupt()
              << " cycles; RAM " << box.avr.static_bytes() << " bytes and " << box.avr.deepest_stack()
              << " of stack");
}

TEST_CASE(
    "the valve's binary closes when the host is silent for 2 s, when its enable line falls, and when told "
    "to") {
  Box box;
  box.hello();
  std::vector<std::uint16_t> ticks;
  for (int n = 0; n < 3000; ++n) ticks.push_back(std::uint16_t(n));
  const auto fire = [&] {
    REQUIRE(box.load(ticks, 2000, 1250) == 0);
    REQUIRE(box.arm() == 0);
    box.avr.edges.clear();
    box.avr.trigger();
    box.avr.run_us(100'000);
    REQUIRE(box.status().state == fvb::State::kFiring);
  };
  fire();
  const std::uint64_t asked = box.avr.cycle();
  box.avr.run_us(2'500'000);
  CHECK_FALSE(box.avr.is_open());
  CHECK(box.avr.edges.back().cycle - asked < 2'010'000 * AvrBox::kCyclesOfAUs);
  CHECK(box.avr.edges.back().cycle - asked > 1'950'000 * AvrBox::kCyclesOfAUs);
  CHECK(box.status().state == fvb::State::kFault);
  fire();
  box.avr.disable();
  CHECK_FALSE(box.avr.is_open());
  CHECK(box.status().state == fvb::State::kDone);
  fire();
  CHECK(box.order(fvb::Type::kAbort) == 0);
  CHECK_FALSE(box.avr.is_open());
  CHECK(box.status().state == fvb::State::kIdle);
}

TEST_CASE("the valve's binary ends pulses that would overheat the coil") {
  Box box;
  box.hello();
  CHECK(box.head(fvb::Type::kBegin, 1, 60'000, 50'001) == int(fvb::Refusal::kRange));
  REQUIRE(box.head(fvb::Type::kSpit, 60'000, 600, 500) == 0);  // 83 % open
  std::uint64_t asked = 0;
  while (box.status().state == fvb::State::kFiring && ++asked < 20) box.avr.run_us(900'000);
  CHECK(box.status().state == fvb::State::kFault);
  CHECK_FALSE(box.avr.is_open());
  CHECK(box.status().next < 12'000);
}

TEST_CASE("a valve's processor that hangs is reset by its watchdog: the valve closes and the count goes on") {
  Box box;
  CHECK(box.hello().boot_count == 1);
  REQUIRE(box.head(fvb::Type::kSpit, 100, 50'000, 30'000) == 0);
  box.avr.run_us(10'000);
  REQUIRE(box.avr.is_open());
  box.avr.hang();
  box.avr.run_us(1'000'000);
  CHECK_FALSE(box.avr.is_open());
  const fvb::Hello h = box.hello();
  CHECK(h.boot_count == 2);
  CHECK(h.reset_cause == 1);
  CHECK(box.status().state == fvb::State::kIdle);
}

TEST_CASE("noise and damaged frames on its line leave the valve's binary answering") {
  Box box;
  box.hello();
  std::mt19937 random(5);
  for (int n = 0; n < 40; ++n) {
    std::vector<std::byte> noise(1 + random() % 700);
    for (std::byte& b : noise)
      b = std::byte(random() % 4 == 0 ? 0xA5 : random() % 3 == 0 ? 0x5A : random() % 256);
    box.avr.send(noise);
    box.avr.run_us(150'000);  // what is left of it is dropped after 50 ms
    CHECK(box.hello().boot_count == 1);
    CHECK_FALSE(box.avr.is_open());
  }
}
