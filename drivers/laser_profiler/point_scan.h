// PointScan controls a point laser that the stage moves over the part: the Keyence LK-G, whose timing input
// hangs on the pulse output of the stage's Y axis. Each pulse gives one value, `TG,1,<value>`; a swath of the
// scan is one column of the grid. Values carry no number: of a swath with a value too few or too many none is
// used, since nobody can tell which row it belongs to.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/laser_point/lkg.h"
#include "drivers/laser_profiler/profiler_driver.h"
#include "drivers/link/silence.h"

namespace firn::drivers {

struct PointScanPlace {
  double middle_mm = 0.0;  ///< part x of the grid's middle, where the stage is with a shift of 0
  double dx_mm = 1.0;      ///< width of a column
};

class PointScan final : public ProfilerDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  PointScan(LaserProfilerOptions config, PointScanPlace place);

  void arm(int rows, std::int64_t now_us, Effects& fx) override;
  /// ProfileRow of every row, or none, and ScanDone come before its Result.
  void end(std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return op_ != Op::kNone; }
  void resumed() override { silence_.end(); }

 private:
  enum class Op : std::uint8_t { kNone, kArm, kEnd };
  enum class Phase : std::uint8_t { kDown, kIdentifying, kReady, kArming, kArmed, kEnding };
  enum Tag : std::uint16_t { kPlain, kLeave, kProgram, kValue };

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
  bool stopping() const override { return false; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  void ask_program() { link_.push(lkg::request("PR", Repeat::kRead, kProgram)); }
  ProfileRow row_of(std::int32_t row, double value_mm) const;
  /// Hands the rows of the swath on, if there is a value for each.
  void scan_over(Effects& fx);
  void refuse(int rows, std::int32_t code, std::string text, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);
  bool accepts(bool armed_too, int rows, Effects& fx);

  LaserProfilerOptions config_;
  PointScanPlace place_;
  lkg::LkgDialect dialect_;
  SilenceWatch silence_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  int rows_ = 0, received_ = 0;  ///< received_: rows that were handed on
  bool scanning_ = false;        ///< armed and ScanDone not sent; survives a lost link
  bool whole_ = true;            ///< the link has held since the arming
  std::vector<float> mm_;        ///< as the instrument said them; NaN = no value
  double read_mm_ = 0.0;         ///< by the order of a person
  int questions_ = 0;            ///< of kEnding
  std::int64_t asked_us_ = 0;
};

}  // namespace firn::drivers
