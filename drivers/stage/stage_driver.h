// StageDriver is the interface of all kinds of stages, and holds the limits that every one keeps: raster
// passes that fire the jet, scans that trigger the profiler, moves, homing. Frame: the nozzle is above part
// point (x, y) when X reads x and Y reads y [mm].
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "drivers/link/driver.h"
#include "drivers/stage/ensemble.h"
#include "drivers/stage/raster.h"
#include "drivers/stage/stage_config.h"
#include "drivers/stage/stage_way.h"
#include "drivers/stage/way_readout.h"

namespace firn::drivers {

inline constexpr char kAxisNames[] = "XYZ";

struct StageOptions : StageConfig {
  ensemble::Table table{};
  double raster_speed_mm_s = 50.0;
  double move_speed_mm_s = 50.0;
  double max_pulse_rate_hz = 2000.0;  ///< that the jet follows
  double poll_end_s = 0.01;           ///< after the move should be over
  double move_timeout_factor = 1.1;   ///< I5: a move takes longer than factor x plan + 0.5 s
  double host_latency_s = 0.0;        ///< see Dialect::allow_host_latency
};

class StageDriver : public Driver {
 public:
  using Options = StageOptions;
  using Measurements = std::tuple<FollowedWay>;

  /// Commands. Each is accepted (a Result follows) or refused at once by a Result{kRefused}; out-of-range
  /// values are refused, not clamped, naming axis, value and limit, before anything is sent. Speed 0 = the
  /// configured one; the nozzle goes to z_mm first (NaN: it stays).
  /// @param lead_mm every pulse comes so much earlier on its way
  /// @param placement of the droplets in their cells @pre check(placement, pattern.spec) passes
  virtual void run_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s,
                        std::int64_t now_us, Effects& fx, double lead_mm = 0.0,
                        const Placement& placement = {}) = 0;
  /// `rows` trigger pulses at y_mm + k pitch_mm, k = 0 .. rows-1, in one steady move along +y at x_mm.
  virtual void scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
                    std::int64_t now_us, Effects& fx) = 0;
  /// NaN leaves an axis where it is.
  virtual void move_to(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
                       Effects& fx) = 0;
  /// Follows a way with the shutter's switches by position; the shutter is closed before and after it. A
  /// FollowedWay comes before the Result of a way that was begun, where the kind records it.
  virtual void trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx) = 0;
  virtual void home(std::int64_t now_us, Effects& fx) = 0;

 protected:
  struct Refusal {
    std::int32_t code = kNoCode;
    std::string text;
  };
  struct PassPlan {
    std::vector<RasterRun> runs;
    std::int64_t expected = 0;  ///< pulses
    double speed_mm_s = 0.0;
  };
  struct ScanPlan {
    double pitch_mm = 0.0;  ///< whole counts
    double speed_mm_s = 0.0;
  };

  /// @throws std::invalid_argument naming the setting, its value and its range
  StageDriver(const Dialect& dialect, StageOptions config);

  /// Each returns why the order is refused, or fills the plan.
  std::optional<Refusal> plan_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s,
                                   double lead_mm, const Placement& placement, PassPlan& plan) const;
  std::optional<Refusal> plan_scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows,
                                   double speed_mm_s, ScanPlan& plan) const;
  /// @param speed_mm_s 0 becomes the configured one
  std::optional<Refusal> plan_move(const std::array<double, 3>& target_mm, double& speed_mm_s) const;
  static void refuse(std::int32_t code, std::string text, Effects& fx);

  StageOptions config_;
  std::array<AxisLimits, 3> limits_;
};

}  // namespace firn::drivers
