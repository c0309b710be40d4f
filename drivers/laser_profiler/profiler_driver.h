// ProfilerDriver is the interface of all kinds of profilers: the rows of a scan, one a trigger.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "drivers/laser_profiler/laser_profiler_config.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

/// One measured line of the surface: a row of the scan, in the part's frame.
struct ProfileRow {
  std::int32_t row = 0;  ///< 0-based row of the scan
  double x0_mm = 0.0;
  double dx_mm = 0.0;
  std::uint32_t trigger_count = 0;
  std::int32_t encoder_count = 0;
  std::vector<float> z_mm;  ///< NaN = no valid sample
  bool by_encoder = true;   ///< encoder_count is the stage's Y; false: only the order tells the place
};

/// The end of a scan: all rows are there, or the scan was ended early.
struct ScanDone {
  std::int32_t rows_expected = 0;
  std::int32_t rows_received = 0;
};

struct LaserProfilerOptions : LaserProfilerConfig {
  double poll_idle_s = 1.0;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

class ProfilerDriver : public Driver {
 public:
  using Options = LaserProfilerOptions;
  using Measurements = std::tuple<ProfileRow, ScanDone>;

  /// Result{kReady} when armed; from then on ProfileRow events, row = triggers since then - 1, and ScanDone
  /// when the last row is there.
  virtual void arm(int rows, std::int64_t now_us, Effects& fx) = 0;
  /// Asks once more, then ScanDone (if it has not been sent) and Result{kDone}.
  virtual void end(std::int64_t now_us, Effects& fx) = 0;

 protected:
  explicit ProfilerDriver(const Dialect& dialect) : Driver(dialect) {}
};

}  // namespace firn::drivers
