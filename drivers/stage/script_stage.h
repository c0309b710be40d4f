// ScriptStage drives a stage by a class in Python. A method returns when the motion is over:
//
//   position()                                       three numbers [mm]
//   move(x_mm, y_mm, z_mm, speed_mm_s)               NaN leaves an axis where it is
//   home()                                           if the class has it
//   fire(y_mm, start_x_mm, end_x_mm, speed_mm_s, at_mm)
//                                                    one straight move along x with a trigger pulse at each
//                                                    of at_mm; returns the pulses that were counted, or None
//   scan(x_mm, start_y_mm, end_y_mm, speed_mm_s, first_y_mm, pitch_mm, rows)
//                                                    the same along +y for the profiler
//
// Limits, run-ups and the order of the runs are those of every stage. A class without fire() or scan() moves
// only: a pass or a scan is refused by name.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/script/script_driver.h"
#include "drivers/stage/stage_driver.h"

namespace firn::drivers {

class ScriptStage final : public ScriptDriver<StageDriver> {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptStage(ScriptOptions script, StageOptions config);

  void run_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s, std::int64_t now_us,
                Effects& fx, double lead_mm = 0.0, const Placement& placement = {}) override;
  void scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
            std::int64_t now_us, Effects& fx) override;
  void move_to(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
               Effects& fx) override;
  void trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx) override;
  void home(std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kHome = kFirstTag, kPosition, kMove, kFire, kScan };
  enum class Op : std::uint8_t { kNone, kPass, kScan, kMove, kHome };

  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t, Effects&) override {}
  Result broken_off(Outcome outcome, std::int32_t code, std::string text) override;
  bool lacks(const char* method, const char* what, Effects& fx);
  void begin(Op op, const char* text, std::int64_t now_us, Effects& fx);
  void go_on(std::int64_t now_us, Effects& fx);
  void move(const std::array<double, 3>& target_mm, double speed_mm_s, std::int64_t now_us);
  void fire(std::int64_t now_us);
  void start_scan(std::int64_t now_us);
  void arrived(const Line& line, std::int64_t now_us, Effects& fx);
  void counted(const Line& line, std::int64_t expected, std::int64_t now_us, Effects& fx);
  void end(Result result, Effects& fx);
  double way_s(double from_mm, double to_mm, double speed_mm_s) const;

  Op op_ = Op::kNone;
  std::vector<RasterRun> runs_;
  std::size_t run_ = 0;
  std::int64_t before_ = 0;    ///< pulses of the runs before
  std::int64_t expected_ = 0;  ///< of the whole order
  bool counts_ = true;         ///< every run so far was counted
  bool launched_ = false;      ///< pulses may be coming
  double speed_mm_s_ = 0.0, pitch_mm_ = 0.0;
  std::array<double, 3> target_mm_{}, position_mm_{};
};

}  // namespace firn::drivers
