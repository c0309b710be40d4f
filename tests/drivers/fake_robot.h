// FakeRobot simulates the V+ program of docs/devices/robot.md as far as a test requires: it executes lines,
// moves at once or after a while, and can lose, damage and delay its replies.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/robot/fvp.h"

namespace firn::drivers::test {

class FakeRobot {
 public:
  /// Bytes of the host at `now_us`; replies are in `out`.
  void take(std::string_view bytes, std::int64_t now_us);
  /// Carries out all motions and events that are due up to `now_us`.
  void advance(std::int64_t now_us);
  std::int64_t next_us() const { return status.running || moving ? end_us : INT64_MAX; }
  void reboot();

  std::string out;
  fvp::Status status{fvp::State::kIdle, 8, 2, 1, false, false, 100, 0, 0, 0, 0, false, 0, {0, 0}};
  fvp::Counts at{0, 0, 150'000, 0};
  std::int64_t move_us = 300'000;
  std::int64_t slip_us = 0;  ///< a path takes this much longer
  bool silent_events = false;
  bool pressed = false;  ///< the emergency stop's button
  int signals = 0;
  bool moving = false;
  std::int64_t end_us = 0;

  /// Record of one executed path.
  struct Run {
    std::vector<fvp::Counts> points;
    int signals = 0;
    bool finished = false;
  };
  std::vector<Run> runs;
  int moves = 0, answered = 0, repeated = 0;
  std::vector<std::string> requests;

 private:
  struct Stored {
    std::size_t n = 0;
    bool complete = false;
    std::vector<fvp::Counts> points;
    fvp::PointsCrc crc;
  };
  std::string execute(WordReader words, std::int64_t now_us);
  std::string path(WordReader words, std::int64_t now_us);
  void settle();
  void end_motion(bool done, std::int64_t now_us);

  std::string line_;
  std::int64_t last_seq_ = 0, events_ = 0, start_us_ = 0;
  std::string last_reply_;
  std::map<std::int64_t, Stored> stored_;
  std::int64_t loading_ = 0;
  fvp::Counts target_{};
};

}  // namespace firn::drivers::test
