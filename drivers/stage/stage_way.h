// StageWay holds a way of X and Y that the controller's own program follows, and the shutter's switches
// along it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/link/link.h"
#include "drivers/stage/ensemble.h"
#include "drivers/stage/raster.h"
#include "drivers/stage/stage_config.h"

namespace firn::drivers {

/// The nozzle's position and velocity over the part at a time.
struct WayKnot {
  double t_s = 0.0, x_mm = 0.0, y_mm = 0.0, vx_mm_s = 0.0, vy_mm_s = 0.0;
};

/// A way of X and Y from rest to rest, cubic between two knots, and the shutter's switches along it.
struct StageWay {
  std::vector<WayKnot> knots;     ///< times ascend from 0
  std::vector<double> switch_mm;  ///< way travelled; the first one opens, the last one closes
};

/// Why the stage cannot follow a way, or nothing.
std::optional<std::string> way_refused(const StageWay& way, const std::array<AxisLimits, 3>& limits,
                                       const StageConfig& config, const ensemble::Table& table);

/// Queues the requests that hand a way to the controller's program, and arm the shutter's switches.
/// @param sample_period_ms of the position that is recorded along the way; 0 = it is not recorded
void push_way(const StageWay& way, std::int64_t sample_period_ms, const StageConfig& config,
              const ensemble::Table& table, Link& link);

}  // namespace firn::drivers
