// AvrBox is a valve's box whose binary runs in simavr: the robot's two lines in, edges of its outputs with
// their cycle.
#pragma once

#include "tests/firmware/avr_mcu.h"

namespace firn::test {

class AvrBox : public AvrMcu {
 public:
  struct Edge {
    std::uint64_t cycle = 0;
    bool hold = false;  ///< the output of 3.5 V, else of 24 V
    bool high = false;
  };

  explicit AvrBox(const std::string& elf, std::vector<std::uint8_t> eeprom = {});

  /// Sends a frame and runs until a whole frame has come or `limit_us` is over. @returns its bytes
  std::string ask(std::span<const std::byte> frame, double limit_us = 400'000);
  void signal(bool high);  ///< the robot's line: its rise starts an armed list
  void enable(bool high);  ///< its fall closes the valve
  void trigger();          ///< a pulse of 1 ms on the robot's line
  void disable();          ///< the enable line falls, and rises 1 ms later

  std::vector<Edge> edges;
  bool is_open() const;
};

}  // namespace firn::test
