// plan_raster computes a pass of a droplet pattern as runs of the stage: each one straight move of one axis
// in one direction, firing at listed distances. Pure geometry; no protocol.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/offsets.h"

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
  double max_rate_hz =
      0.0;  ///< that the jet follows: runs whose droplets are nearer than a pitch are slower; 0: any
};

/// One straight run along x at y_mm: the increments are unsigned counts from the arming position, then from
/// pulse to pulse (rounded so that no error adds up).
struct RasterRun {
  int row = 0;  ///< j
  double y_mm = 0.0;
  double start_x_mm = 0.0;
  double end_x_mm = 0.0;
  double speed_mm_s = 0.0;  ///< of the params, or as much slower as its nearest droplets need
  std::vector<std::int64_t> increments;
  std::size_t first_drop = 0;  ///< index in the firing order of the first pulse
};

/// Runs of pass `pass` (0-based) in firing order (core/grid/firing_order.h); rows without drops give none,
/// rows with more than array_limit drops, or with several sub-rows, give several.
/// @pre check(placement, pattern.spec) passes
std::vector<RasterRun> plan_raster(const DropletPattern& pattern, int pass, const RasterParams& params,
                                   const Placement& placement = {});

/// Time of these runs with the turns between them, without the pass's start and end.
double raster_time_s(const std::vector<RasterRun>& runs, const RasterParams& params);

/// Share of the jet's rate that droplets nearer than a pitch may take: the rest is for the ripple of the
/// stage's speed and the rounding of pulses to counts.
inline constexpr double kRateShare = 0.95;
/// Turn of the stage between two runs: move, questions, arming, measured on the simulated stage.
inline constexpr double kTurn_s = 0.065;

/// The distance Placement::apart_mm with which a pass is quicker: 0, each run as slow as its nearest droplets
/// need, or that which full speed needs, where rows with nearer droplets take two runs.
/// @pre as plan_raster
double quicker_apart_mm(const DropletPattern& fires, const RasterParams& params, Placement placement);

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
