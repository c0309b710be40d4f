// FakeLaser simulates the LK-G of docs/devices/laser_point.md as far as a test requires: modes, settings,
// storage, paced dump.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace firn::drivers::test {

class FakeLaser {
 public:
  void take(std::string_view bytes, std::int64_t now_us);
  void advance(std::int64_t now_us);
  std::int64_t next_us() const { return pending_us_ != 0 ? pending_us_ : INT64_MAX; }
  void trigger(std::int64_t now_us) { trigger_us_ = armed ? now_us : 0; }
  void reboot();

  std::string out;
  bool communication = false, armed = false;
  int program = 5, surface = -1, sampling = -1, averaging = -1, cycle = -1;
  std::vector<std::string> commands;
  std::vector<double> heights;       ///< values to measure, sample by sample (NaN = nothing)
  double now_mm = 1.5;               ///< of M1
  int refuse_next = -1;              ///< error of the next command
  bool timing_before_reply = false;  ///< a TG line comes before every reply
  std::size_t stored = 0;

 private:
  std::string execute(std::string_view command, std::int64_t now_us);
  void count(std::int64_t now_us);

  std::string line_, pending_;
  std::int64_t trigger_us_ = 0, pending_us_ = 0;
};

}  // namespace firn::drivers::test
