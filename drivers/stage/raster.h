// plan_raster computes a pass of a droplet pattern as runs of the stage: each one straight move of one axis
// in one direction, firing at listed distances. Pure geometry; no protocol.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/grid/grid.h"

namespace firn::drivers {

struct AxisLimits {
  double min_mm = 0.0;
  double max_mm = 0.0;
  double max_speed_mm_s = 0.0;
  bool operator==(const AxisLimits&) const = default;
};

struct RasterParams {
  double speed_mm_s = 50.0;
  double acceleration_mm_s2 = 2000.0;
  double lead_mm = 0.0;    ///< every pulse comes so much earlier on its way
  double margin_mm = 0.1;  ///< run-up and run-out beyond those of the acceleration
  double counts_per_mm = 10'000;
  int array_limit = 4046;  ///< most pulses of one run
};

/// One straight run along x at y_mm: the increments are unsigned counts from the arming position, then from
/// pulse to pulse (rounded so that no error adds up).
struct RasterRun {
  int row = 0;  ///< j
  double y_mm = 0.0;
  double start_x_mm = 0.0;
  double end_x_mm = 0.0;
  std::vector<std::int64_t> increments;
  std::size_t first_drop = 0;  ///< index in the firing order of the first pulse
};

/// Runs of pass `pass` (0-based) in firing order (core/grid/firing_order.h); rows without drops give none,
/// rows with more than array_limit drops give several.
std::vector<RasterRun> plan_raster(const DropletPattern& pattern, int pass, const RasterParams& params);

struct PulseRange {
  std::int64_t least = 0;
  std::int64_t most = 0;
  bool contains(std::int64_t n) const { return least <= n && n <= most; }
};

/// Computes how many pulses a run can have fired whose axis came to rest at `x_mm`: those that lie before it,
/// less those of the last `stop_mm`, which it may have travelled without a trigger. `slack_mm`: error of
/// x_mm.
PulseRange pulses_by_place(const RasterRun& run, double x_mm, double stop_mm, double slack_mm,
                           double counts_per_mm);

/// Run-up needed to reach `speed` [mm].
double run_up_mm(const RasterParams& params);

/// Time for a straight move of `distance_mm` from rest to rest, trapezoidal.
double move_time_s(double distance_mm, double speed_mm_s, double acceleration_mm_s2);

/// Why `value_mm` is outside the limits of the axis, or nothing.
std::optional<std::string> limit_broken(char axis_name, double value_mm, const AxisLimits& limits);

}  // namespace firn::drivers
