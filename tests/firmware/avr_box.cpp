#include "tests/firmware/avr_box.h"

#include <simavr/avr_eeprom.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#include <algorithm>
#include <stdexcept>

#include "drivers/valve/fvb.h"

namespace firn::test {
namespace {

constexpr int kSpikePin = 6, kHoldPin = 7, kTriggerPin = 4, kEnablePin = 5;
constexpr std::uint64_t kByteCycles = 16'000'000ull * 10 / 115'200;
constexpr std::uint32_t kRamEnd = 0x21FF, kSp = 0x5D;

}  // namespace

struct AvrBox::Mcu {
  avr_t* avr = nullptr;
  avr_irq_t *input = nullptr, *trigger = nullptr, *enable = nullptr;
  ~Mcu() {
    if (avr) avr_terminate(avr);
  }
};

struct AvrBox::Hooks {
  static void byte(avr_irq_t*, std::uint32_t value, void* box) {
    static_cast<AvrBox*>(box)->sent_ += char(value);
  }
  static void spike(avr_irq_t*, std::uint32_t value, void* box) { note(box, false, value); }
  static void hold(avr_irq_t*, std::uint32_t value, void* box) { note(box, true, value); }
  static void note(void* p, bool hold, std::uint32_t value) {
    auto& box = *static_cast<AvrBox*>(p);
    box.edges.push_back({box.mcu_->avr->cycle, hold, (value & 1) != 0});
  }
  static void go_on(avr_irq_t*, std::uint32_t, void* box) { static_cast<AvrBox*>(box)->full_ = false; }
  static void pause(avr_irq_t*, std::uint32_t, void* box) { static_cast<AvrBox*>(box)->full_ = true; }
  static void interrupt(avr_irq_t*, std::uint32_t value, void* p) {
    auto& box = *static_cast<AvrBox*>(p);
    const std::uint64_t now = box.mcu_->avr->cycle;
    if (value != 0) {
      box.entered_ = now;
    } else if (box.entered_ != 0) {
      box.longest_interrupt_ = std::max(box.longest_interrupt_, now - box.entered_);
      box.entered_ = 0;
    }
  }
};

AvrBox::AvrBox(const std::string& elf, std::vector<std::uint8_t> eeprom) : mcu_(std::make_unique<Mcu>()) {
  elf_firmware_t binary{};
  if (elf_read_firmware(elf.c_str(), &binary) != 0) throw std::runtime_error("cannot read " + elf);
  static_bytes_ = binary.datasize + binary.bsssize;
  avr_t* avr = mcu_->avr = avr_make_mcu_by_name("atmega2560");
  if (!avr) throw std::runtime_error("simavr knows no atmega2560");
  avr_init(avr);
  avr->log = LOG_NONE;
  avr->frequency = 16'000'000;
  binary.frequency = 16'000'000;
  avr_load_firmware(avr, &binary);
  std::uint32_t flags = 0;
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);  // its bytes are not the console's
  if (!eeprom.empty()) {
    avr_eeprom_desc_t kept{eeprom.data(), 0, std::uint32_t(eeprom.size())};
    avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &kept);
  }
  mcu_->input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), &Hooks::byte,
                          this);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), kSpikePin), &Hooks::spike, this);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), kHoldPin), &Hooks::hold, this);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), &Hooks::go_on,
                          this);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), &Hooks::pause,
                          this);
  mcu_->trigger = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('E'), kTriggerPin);
  mcu_->enable = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('E'), kEnablePin);
  avr_irq_register_notify(avr_get_interrupt_irq(avr, AVR_INT_ANY) + AVR_INT_IRQ_RUNNING, &Hooks::interrupt,
                          this);
  avr_raise_irq(mcu_->enable, 1);
  run_us(20'000);
}

AvrBox::~AvrBox() = default;

std::uint64_t AvrBox::cycle() const { return mcu_->avr->cycle; }
bool AvrBox::is_open() const {
  constexpr std::uint32_t kPortB = 0x25;
  return (mcu_->avr->data[kPortB] & (1 << kSpikePin | 1 << kHoldPin)) != 0;
}
std::uint32_t AvrBox::deepest_stack() const { return kRamEnd - lowest_sp_; }

std::vector<std::uint8_t> AvrBox::eeprom() const {
  constexpr std::uint32_t kBytes = 4096;
  std::vector<std::uint8_t> bytes(kBytes);
  avr_eeprom_desc_t all{bytes.data(), 0, kBytes};
  avr_ioctl(mcu_->avr, AVR_IOCTL_EEPROM_GET, &all);
  return bytes;
}

void AvrBox::step() {
  avr_t* avr = mcu_->avr;
  const int state = avr_run(avr);
  if (state == cpu_Crashed || state == cpu_Done)
    throw std::runtime_error("the simulated processor has stopped");
  const std::uint32_t sp = avr->data[kSp] | std::uint32_t(avr->data[kSp + 1]) << 8;
  constexpr std::uint32_t kFirstOfRam = 0x200;
  if (sp >= kFirstOfRam) lowest_sp_ = std::min(lowest_sp_, sp);
}

void AvrBox::run_us(double us) {
  const std::uint64_t until = cycle() + std::uint64_t(us * double(kCyclesOfAUs));
  while (cycle() < until) step();
}

void AvrBox::send(std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) {
    while (cycle() < sent_until_ || full_) step();
    avr_raise_irq(mcu_->input, std::uint32_t(b));
    sent_until_ = cycle() + kByteCycles;
  }
}

std::string AvrBox::ask(std::span<const std::byte> frame, double limit_us) {
  sent_.clear();
  send(frame);
  const std::uint64_t until = cycle() + std::uint64_t(limit_us * double(kCyclesOfAUs));
  std::size_t seen = 0;
  while (cycle() < until) {
    step();
    if (sent_.size() == seen) continue;
    seen = sent_.size();
    const drivers::fvb::Found f = drivers::fvb::find(std::as_bytes(std::span(sent_.data(), sent_.size())));
    if (f.kind == drivers::fvb::Found::Kind::kFrame) break;
  }
  return sent_;
}

void AvrBox::trigger() {
  avr_raise_irq(mcu_->trigger, 1);
  run_us(1000);
  avr_raise_irq(mcu_->trigger, 0);
}

void AvrBox::disable() {
  avr_raise_irq(mcu_->enable, 0);
  run_us(1000);
  avr_raise_irq(mcu_->enable, 1);
}

void AvrBox::hang() {
  avr_t* avr = mcu_->avr;
  constexpr std::uint32_t kUnused = 0x3F000;  // of flash
  avr->flash[kUnused] = 0xFF;
  avr->flash[kUnused + 1] = 0xCF;  // rjmp to itself
  avr->sreg[S_I] = 0;
  avr->pc = kUnused;
}

}  // namespace firn::test
