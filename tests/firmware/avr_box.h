// AvrBox runs the valve's binary for the ATmega2560 in simavr: bytes of its serial line in and out, the
// robot's two lines in, edges of its outputs with their cycle.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace firn::test {

class AvrBox {
 public:
  static constexpr std::uint64_t kCyclesOfAUs = 16;  ///< 16 MHz
  struct Edge {
    std::uint64_t cycle = 0;
    bool hold = false;  ///< the output of 3.5 V, else of 24 V
    bool high = false;
  };

  /// @param elf path of the binary
  /// @param eeprom as another box has left it; empty: erased
  explicit AvrBox(const std::string& elf, std::vector<std::uint8_t> eeprom = {});
  ~AvrBox();

  void run_us(double us);
  void send(std::span<const std::byte> bytes);  ///< at the line's speed
  /// Sends a frame and runs until a whole frame has come or `limit_us` is over. @returns its bytes
  std::string ask(std::span<const std::byte> frame, double limit_us = 400'000);
  void trigger();  ///< a pulse of 1 ms on the robot's line
  void disable();  ///< the enable line falls, and rises 1 ms later
  /// The processor goes round in a loop without interrupts from now on, as a program that has lost its way.
  void hang();

  std::vector<Edge> edges;
  std::uint64_t cycle() const;
  bool is_open() const;
  std::uint64_t longest_interrupt() const { return longest_interrupt_; }  ///< cycles, entry to return
  std::uint32_t static_bytes() const { return static_bytes_; }            ///< of RAM
  std::uint32_t deepest_stack() const;                                    ///< bytes, so far
  std::vector<std::uint8_t> eeprom() const;

 private:
  struct Hooks;
  void step();

  struct Mcu;
  std::unique_ptr<Mcu> mcu_;
  std::string sent_;
  bool full_ = false;  ///< simavr's own line, which takes twice as long for a byte
  std::uint64_t longest_interrupt_ = 0, entered_ = 0, sent_until_ = 0;
  std::uint32_t static_bytes_ = 0, lowest_sp_ = 0xFFFF;
};

}  // namespace firn::test
