#include "tests/firmware/avr_mcu.h"

#include <simavr/avr_eeprom.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_spi.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace firn::test {
namespace {

constexpr std::uint32_t kRamEnd = 0x21FF, kSp = 0x5D;

}  // namespace

struct AvrMcu::Avr {
  avr_t* avr = nullptr;
  avr_irq_t *input = nullptr, *spi = nullptr;
  ~Avr() {
    if (avr) avr_terminate(avr);
  }
};

struct AvrMcu::Hooks {
  static void byte(avr_irq_t*, std::uint32_t value, void* mcu) {
    static_cast<AvrMcu*>(mcu)->sent_ += char(value);
  }
  static void edge(avr_irq_t*, std::uint32_t value, void* p) {
    const auto& watched = *static_cast<Watched*>(p);
    *watched.seen = true;
    watched.edge((value & 1) != 0);
  }
  static void go_on(avr_irq_t*, std::uint32_t, void* mcu) { static_cast<AvrMcu*>(mcu)->full_ = false; }
  static void pause(avr_irq_t*, std::uint32_t, void* mcu) { static_cast<AvrMcu*>(mcu)->full_ = true; }
  static void spi(avr_irq_t*, std::uint32_t value, void* p) {
    auto& mcu = *static_cast<AvrMcu*>(p);
    avr_raise_irq(mcu.mcu_->spi, mcu.exchange_(std::uint8_t(value)));
  }
  static void interrupt(avr_irq_t*, std::uint32_t value, void* p) {
    auto& mcu = *static_cast<AvrMcu*>(p);
    const std::uint64_t now = mcu.mcu_->avr->cycle;
    if (value != 0) {
      mcu.entered_ = now;
    } else if (mcu.entered_ != 0) {
      mcu.longest_interrupt_ = std::max(mcu.longest_interrupt_, now - mcu.entered_);
      mcu.entered_ = 0;
    }
  }
  static void sleep(avr_t*, avr_cycle_count_t) {}  // simavr's own sleeps on the wall's clock
};

AvrMcu::AvrMcu(const std::string& elf, std::vector<std::uint8_t> eeprom, int baud)
    : mcu_(std::make_unique<Avr>()), byte_cycles_(16'000'000ull * 10 / std::uint64_t(baud)) {
  elf_firmware_t binary{};
  if (elf_read_firmware(elf.c_str(), &binary) != 0) throw std::runtime_error("cannot read " + elf);
  static_bytes_ = binary.datasize + binary.bsssize;
  avr_t* avr = mcu_->avr = avr_make_mcu_by_name("atmega2560");
  if (!avr) throw std::runtime_error("simavr knows no atmega2560");
  avr_init(avr);
  avr->log = LOG_NONE;
  avr->sleep = &Hooks::sleep;
  avr->frequency = 16'000'000;
  binary.frequency = 16'000'000;
  avr_load_firmware(avr, &binary);
  std::uint32_t flags = 0;
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);  // its bytes are not the console's
  if (!eeprom.empty()) {
    avr_eeprom_desc_t kept{eeprom.data(), 0, std::uint32_t(eeprom.size())};
    avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &kept);
  }
  const auto uart = [&](int irq) { return avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), irq); };
  mcu_->input = uart(UART_IRQ_INPUT);
  avr_irq_register_notify(uart(UART_IRQ_OUTPUT), &Hooks::byte, this);
  avr_irq_register_notify(uart(UART_IRQ_OUT_XON), &Hooks::go_on, this);
  avr_irq_register_notify(uart(UART_IRQ_OUT_XOFF), &Hooks::pause, this);
  avr_irq_register_notify(avr_get_interrupt_irq(avr, AVR_INT_ANY) + AVR_INT_IRQ_RUNNING, &Hooks::interrupt,
                          this);
}

AvrMcu::~AvrMcu() = default;

std::uint64_t AvrMcu::cycle() const { return mcu_->avr->cycle; }
std::uint8_t AvrMcu::data(std::uint32_t address) const { return mcu_->avr->data[address]; }
std::uint32_t AvrMcu::deepest_stack() const { return kRamEnd - lowest_sp_; }
std::string AvrMcu::take_sent() { return std::exchange(sent_, {}); }

void AvrMcu::watch(char port, int bit, Edge edge) {
  watched_.push_back({std::move(edge), &seen_});
  avr_irq_register_notify(avr_io_getirq(mcu_->avr, AVR_IOCTL_IOPORT_GETIRQ(port), bit), &Hooks::edge,
                          &watched_.back());
}

void AvrMcu::drive(char port, int bit, bool high) {
  avr_raise_irq(avr_io_getirq(mcu_->avr, AVR_IOCTL_IOPORT_GETIRQ(port), bit), high ? 1 : 0);
}

void AvrMcu::on_spi(std::function<std::uint8_t(std::uint8_t)> exchange) {
  exchange_ = std::move(exchange);
  mcu_->spi = avr_io_getirq(mcu_->avr, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(mcu_->avr, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_OUTPUT), &Hooks::spi,
                          this);
}

std::vector<std::uint8_t> AvrMcu::eeprom() const {
  constexpr std::uint32_t kBytes = 4096;
  std::vector<std::uint8_t> bytes(kBytes);
  avr_eeprom_desc_t all{bytes.data(), 0, kBytes};
  avr_ioctl(mcu_->avr, AVR_IOCTL_EEPROM_GET, &all);
  return bytes;
}

void AvrMcu::step() {
  avr_t* avr = mcu_->avr;
  if (!coming_.empty() && avr->cycle >= sent_until_ && !full_) {
    avr_raise_irq(mcu_->input, std::uint32_t(coming_.front()));
    coming_.pop_front();
    sent_until_ = avr->cycle + byte_cycles_;
  }
  const int state = avr_run(avr);
  if (state == cpu_Crashed || state == cpu_Done)
    throw std::runtime_error("the simulated processor has stopped");
  const std::uint32_t sp = avr->data[kSp] | std::uint32_t(avr->data[kSp + 1]) << 8;
  constexpr std::uint32_t kFirstOfRam = 0x200;
  if (sp >= kFirstOfRam) lowest_sp_ = std::min(lowest_sp_, sp);
}

void AvrMcu::run_to(std::uint64_t until) {
  while (cycle() < until) step();
}

void AvrMcu::run_to_edge(std::uint64_t until) {
  seen_ = false;
  while (cycle() < until && !seen_) step();
}

void AvrMcu::run_us(double us) { run_to(cycle() + std::uint64_t(us * double(kCyclesOfAUs))); }

void AvrMcu::give(std::span<const std::byte> bytes) {
  coming_.insert(coming_.end(), bytes.begin(), bytes.end());
}

void AvrMcu::send(std::span<const std::byte> bytes) {
  give(bytes);
  while (!coming_.empty()) step();
}

void AvrMcu::hang() {
  avr_t* avr = mcu_->avr;
  constexpr std::uint32_t kUnused = 0x3F000;  // of flash
  avr->flash[kUnused] = 0xFF;
  avr->flash[kUnused + 1] = 0xCF;  // rjmp to itself
  avr->sreg[S_I] = 0;
  avr->state = cpu_Running;
  avr->pc = kUnused;
}

}  // namespace firn::test
