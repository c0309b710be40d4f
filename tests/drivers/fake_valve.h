// FakeValve simulates the firmware of docs/devices/valve.md as far as a test requires.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/valve/fvb.h"

namespace firn::drivers::test {

class FakeValve {
 public:
  void take(std::string_view bytes, std::int64_t now_us);
  void advance(std::int64_t now_us);
  std::int64_t next_us() const { return INT64_MAX; }
  void trigger(std::int64_t now_us);
  void reboot();

  std::string out;
  fvb::Status status{1, fvb::State::kIdle, 0, 0, 0, 0};
  double clock = 1.0;                  ///< of the controller against true time
  std::vector<std::int64_t> shots_us;  ///< every pulse that was ever given
  std::vector<std::uint16_t> list;
  std::vector<fvb::Type> requests;
  int corrupt_ends = 0;  ///< so many ENDs are refused

 private:
  void execute(const fvb::Found& f, std::int64_t now_us);
  void answer(fvb::Type type, std::uint8_t seq, int refusal);

  std::string held_;
  std::uint8_t last_seq_ = 0;
  std::string last_reply_;
  fvb::Begin begin_;
  std::int64_t trigger_us_ = 0, heard_us_ = 0;
};

}  // namespace firn::drivers::test
