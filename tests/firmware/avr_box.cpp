#include "tests/firmware/avr_box.h"

#include "drivers/valve/fvb.h"

namespace firn::test {
namespace {

constexpr int kSpikePin = 6, kHoldPin = 7, kTriggerPin = 4, kEnablePin = 5;

}  // namespace

AvrBox::AvrBox(const std::string& elf, std::vector<std::uint8_t> kept) : AvrMcu(elf, std::move(kept)) {
  watch('B', kSpikePin, [this](bool high) { edges.push_back({cycle(), false, high}); });
  watch('B', kHoldPin, [this](bool high) { edges.push_back({cycle(), true, high}); });
  enable(true);
  run_us(20'000);
}

void AvrBox::signal(bool high) { drive('E', kTriggerPin, high); }
void AvrBox::enable(bool high) { drive('E', kEnablePin, high); }

bool AvrBox::is_open() const {
  constexpr std::uint32_t kPortB = 0x25;
  return (data(kPortB) & (1 << kSpikePin | 1 << kHoldPin)) != 0;
}

std::string AvrBox::ask(std::span<const std::byte> frame, double limit_us) {
  take_sent();
  send(frame);
  const std::uint64_t until = cycle() + std::uint64_t(limit_us * double(kCyclesOfAUs));
  std::size_t seen = 0;
  while (cycle() < until) {
    step();
    if (sent().size() == seen) continue;
    seen = sent().size();
    const drivers::fvb::Found f = drivers::fvb::find(std::as_bytes(std::span(sent().data(), sent().size())));
    if (f.kind == drivers::fvb::Found::Kind::kFrame) break;
  }
  return take_sent();
}

void AvrBox::trigger() {
  signal(true);
  run_us(1000);
  signal(false);
}

void AvrBox::disable() {
  enable(false);
  run_us(1000);
  enable(true);
}

}  // namespace firn::test
