// AvrMcu runs a binary for the ATmega2560 at 16 MHz in simavr: bytes of its serial line in and out, pins,
// EEPROM.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace firn::test {

class AvrMcu {
 public:
  static constexpr std::uint64_t kCyclesOfAUs = 16;

  /// @param elf path of the binary
  /// @param eeprom as another one has left it; empty: erased
  /// @param baud of its serial line
  explicit AvrMcu(const std::string& elf, std::vector<std::uint8_t> eeprom = {}, int baud = 115'200);
  ~AvrMcu();

  void step();  ///< one instruction, or a sleep until the next event
  void run_to(std::uint64_t cycle);
  void run_to_edge(std::uint64_t cycle);  ///< ends also at an edge of a watched output
  void run_us(double us);
  std::uint64_t cycle() const;

  /// Queues bytes of the host, which arrive at the line's speed.
  void give(std::span<const std::byte> bytes);
  void send(std::span<const std::byte> bytes);  ///< the same, and runs until the last one has arrived
  const std::string& sent() const { return sent_; }
  std::string take_sent();  ///< bytes for the host since the last call

  using Edge = std::function<void(bool high)>;
  void watch(char port, int bit, Edge edge);  ///< an output
  void drive(char port, int bit, bool high);  ///< an input
  /// Calls `exchange` with each byte that the SPI sends; it returns the byte that comes in.
  void on_spi(std::function<std::uint8_t(std::uint8_t out)> exchange);
  std::uint8_t data(std::uint32_t address) const;  ///< registers and RAM

  /// The processor goes round in a loop without interrupts from now on, as a program that has lost its way.
  void hang();
  std::uint64_t longest_interrupt() const { return longest_interrupt_; }  ///< cycles, entry to return
  std::uint32_t static_bytes() const { return static_bytes_; }            ///< of RAM
  std::uint32_t deepest_stack() const;                                    ///< bytes, so far
  std::vector<std::uint8_t> eeprom() const;

 private:
  struct Avr;
  struct Hooks;

  std::unique_ptr<Avr> mcu_;
  std::string sent_;
  std::deque<std::byte> coming_;
  struct Watched {
    Edge edge;
    bool* seen;
  };
  std::deque<Watched> watched_;
  std::function<std::uint8_t(std::uint8_t)> exchange_;
  bool seen_ = false;  ///< an edge
  bool full_ = false;  ///< simavr's own line, which takes twice as long for a byte
  std::uint64_t byte_cycles_;
  std::uint64_t longest_interrupt_ = 0, entered_ = 0, sent_until_ = 0;
  std::uint32_t static_bytes_ = 0, lowest_sp_ = 0xFFFF;
};

}  // namespace firn::test
