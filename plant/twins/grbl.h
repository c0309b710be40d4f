// GrblTwin simulates a GRBL 1.1 board with three axes: lines of G-code with a planner of 16 blocks, real-time
// bytes, hold, reset, alarms, the laser output in laser mode, and the box that counts Y steps while the
// coolant output is on. Written from gnea/grbl's documents, not from the driver (docs/plant.md,
// docs/devices/grbl.md).
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "plant/config/world_config.h"
#include "plant/twins/stage_place.h"
#include "plant/twins/twin.h"

namespace firn::plant {

class GrblTwin final : public Twin, public StagePlace {
 public:
  GrblTwin(const StageParams& params, Wires& wires);

  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;
  bool device_event_replies() const override { return !lines_.empty() || state_ == State::kHoming; }
  void reboot(std::int64_t now_us) override;
  /// 0: mended. 1: a hard limit is hit. 2: the safety door opens. 3: no pulse leaves the laser output. 4: its
  /// settings are another board's ($100 halved).
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override;

  Vec3 position_mm(std::int64_t now_us) const override;
  double velocity_mm_s(int axis, std::int64_t now_us) const override;
  std::int64_t encoder_counts(int axis, double position_mm) const override;

  bool output() const { return output_; }
  bool moving() const {
    return state_ == State::kRunning || state_ == State::kHolding || state_ == State::kHoming;
  }

 private:
  enum class State : std::uint8_t { kIdle, kRunning, kHolding, kHeld, kAlarm, kHoming, kDoor };
  struct Block {
    Vec3 to_mm{};
    double feed_mm_s = 0.0, power = 0.0;
    void io(Archive& a) { a.all(to_mm, feed_mm_s, power); }
  };

  void real_time(char byte, std::int64_t now_us);
  void reset(std::int64_t now_us);
  void alarm(int number, std::int64_t now_us);
  void say(std::string_view text, std::int64_t now_us) { link_.reply(std::string(text) + "\r\n", now_us); }
  void report(std::int64_t now_us);
  void interpret(std::int64_t now_us);
  /// Returns the answer; empty: the line waits.
  std::string execute(std::string_view line, std::int64_t now_us);
  std::string settings() const;
  std::string g_code(std::string_view line, std::int64_t now_us);
  void advance(std::int64_t now_us);
  void travel(double mm, std::int64_t from_us, std::int64_t to_us);
  void begin_block(std::int64_t t_us);
  void switch_output(bool on, std::int64_t t_us);
  double collinear_mm() const;
  Vec3 place() const;

  StageParams params_;
  Wires& wires_;
  State state_ = State::kAlarm;  // until it is homed
  std::string line_;
  std::deque<std::string> lines_;
  std::deque<Block> blocks_;  // the first one is under way
  Vec3 from_mm_{}, direction_{};
  double length_mm_ = 0.0, done_mm_ = 0.0;  // of the first block
  double speed_mm_s_ = 0.0;
  std::int64_t last_us_ = 0, homed_us_ = 0;
  // Modal state.
  Vec3 goal_mm_{};  // end of the last block
  double feed_mm_s_ = 0.0, power_ = 0.0;
  bool spindle_ = false, coolant_ = false, output_ = false;
  double box_mm_ = 0.0;  // Y travelled since the coolant output went on
  std::int64_t box_pulses_ = 0;
  bool mute_ = false, other_board_ = false;
};

}  // namespace firn::plant
