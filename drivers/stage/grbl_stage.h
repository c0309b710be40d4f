// GrblStage controls a GRBL 1.1 board as a stage: moves, homing, raster passes whose droplets the board's
// laser output triggers, and scans where a counting box on the step lines triggers the profiler.
// docs/devices/grbl.md has the facts and the limits of such a board: it counts no pulses, has no
// watchdog, and knows no feedback but its own steps.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/stage/grbl.h"
#include "drivers/stage/stage_driver.h"

namespace firn::drivers {

class GrblStage final : public StageDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit GrblStage(StageOptions config);

  void run_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s, std::int64_t now_us,
                Effects& fx, double lead_mm = 0.0, const Placement& placement = {}) override;
  /// Refused without stage.scan_box.
  void scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
            std::int64_t now_us, Effects& fx) override;
  void move_to(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
               Effects& fx) override;
  /// Refused: the board follows G-code, not cubic pieces with a shutter.
  void trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx) override;
  void home(std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return op_ != Op::kNone; }
  /// As last reported, in work coordinates [mm]; NaN = not known.
  double position_mm(int axis) const { return position_mm_[std::size_t(axis)]; }

 private:
  enum class Op : std::uint8_t { kNone, kPass, kScan, kMove, kHome };
  enum class Phase : std::uint8_t {
    kDown,
    kHolding,  // it is told to hold, and asked until it stands
    kSetup,    // reset, settings
    kLooking,  // its state is asked
    kHoming,
    kReady,
    kPlacing,  // where it is, before an order
    kToStart,
    kRunning,  // lines of a run go out, then it is asked until it stands at its end
    kDead,     // latched: a new connection, or home(), leaves it
  };
  static constexpr std::int64_t kAskMoving_us = 50'000;  // a report costs 60 bytes of 11,500 a second
  enum Tag : std::uint16_t { kPlain, kBoot, kLook, kHomed, kSpan };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void unsolicited(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  void tick(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return stopping_; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;
  void permit_reset() override { was_homed_ = false; }

  bool accepts(Op op, Effects& fx);
  void begin(Op op, std::string_view text, Effects& fx);
  void finish(Result result, Effects& fx);
  void hold(std::string why, std::int32_t code, std::int64_t now_us, Effects& fx);
  void halted(std::int64_t now_us, Effects& fx);
  void set_up();
  void push_homing();
  void take(const grbl::Report& report, std::int64_t now_us, Effects& fx);
  void look_around(const grbl::Report& report, Effects& fx);
  void die(std::int32_t code, const std::string& why, Effects& fx);
  std::string mismatch() const;
  std::string setting_text(int number) const;
  double setting(int number) const;
  void go(const std::array<double, 3>& target_mm, double speed_mm_s, std::int64_t now_us);
  void go_on(std::int64_t now_us, Effects& fx);
  void start_run(std::int64_t now_us);
  void arrived(std::int64_t now_us, Effects& fx);
  void settled(Effects& fx);
  std::string rate_refusal(const PassPlan& plan) const;
  double pulse_mm(double speed_mm_s) const;
  double step_mm(std::size_t axis) const;
  void expect_end(double mm, double speed_mm_s, std::int64_t now_us);

  grbl::GrblDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  bool stopping_ = false;
  bool set_up_next_ = false;  // it has stood: the next connection of the link sets it up
  bool homed_ = false;
  bool was_homed_ =
      false;  ///< since the person's reset: an alarm after that is none of a board that was switched on
  std::string name_;  // of $I
  std::map<int, double> settings_;
  std::array<double, 3> position_mm_, target_mm_{}, offset_mm_{};
  // The order in progress.
  std::vector<RasterRun> runs_;
  std::size_t run_ = 0;
  std::int64_t before_ = 0, expected_ = 0;
  double speed_mm_s_ = 0.0, pitch_mm_ = 0.0, z_mm_ = 0.0;
  std::vector<std::string> lines_;  // of the run, not sent yet
  std::size_t next_line_ = 0;
  bool launched_ = false;  // pulses may come
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
  std::int64_t ask_us_ = 0;    // for its state
  std::int64_t until_us_ = 0;  // it must stand by then
};

}  // namespace firn::drivers
