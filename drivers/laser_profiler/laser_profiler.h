// LaserProfiler controls the laser profiler Keyence LJ-V7000, triggered by the pulse output of the stage's Y
// axis. While armed, the instrument is asked for its newest profile; a new trigger count is a new row. A row
// that was overwritten before it was asked for is absent; with `read = "memory"` those between are asked for
// by their numbers, and only what the instrument's memory no longer holds is absent.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/laser_profiler/ljv.h"
#include "drivers/laser_profiler/profiler_driver.h"
#include "drivers/link/silence.h"

namespace firn::drivers {

class LaserProfiler final : public ProfilerDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit LaserProfiler(LaserProfilerOptions config);

  /// Reads the trigger count first.
  void arm(int rows, std::int64_t now_us, Effects& fx) override;
  void end(std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return op_ != Op::kNone; }

  void resumed() override { silence_.end(); }

 private:
  enum class Op : std::uint8_t { kNone, kArm, kEnd };
  enum class Phase : std::uint8_t { kDown, kIdentifying, kReady, kArming, kArmed, kEnding };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  void tick(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return false; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  void take(std::int64_t now_us, Effects& fx);
  void take_all(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx);
  bool by_number() const { return config_.read == ProfileRead::kMemory; }
  /// Asks for the next profiles that the instrument holds and we have not. @returns false when there are none
  bool ask_by_number();
  ProfileRow in_part_frame(std::uint32_t row) const;
  void scan_over(Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);
  std::int64_t next_poll_us() const;

  LaserProfilerOptions config_;
  ljv::LjvDialect dialect_;
  SilenceWatch silence_;
  ljv::RawProfile raw_;
  // Numbers of profiles: not read yet, held, and asked for without an answer that brought it.
  std::uint32_t next_number_ = 0, newest_number_ = 0;
  std::optional<std::uint32_t> asked_number_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  int rows_ = 0;
  int received_ = 0;
  std::uint32_t base_trigger_ = 0;
  std::uint32_t last_trigger_ = 0;
  std::uint32_t last_row_ = 0;
  std::int64_t last_row_us_ = 0;  ///< 0 = no row yet
  std::int64_t row_us_ = 0;       ///< shortest time from row to row so far, 0 = not known
  bool scanning_ = false;         ///< armed and ScanDone not sent; survives a lost link
  bool asked_ = false;
};

}  // namespace firn::drivers
