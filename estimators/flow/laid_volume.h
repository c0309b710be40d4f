// add_laid() computes the height map that the pulses of executed paths deposit at the calibrated flow.
#pragma once

#include <span>

#include "core/grid/grid.h"
#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/tool.h"
#include "core/path/path.h"

namespace firn::flow {

/// One list of a path, and where its arm was.
struct FiredList {
  const Trajectory& motion;
  double start_s = 0.0;  ///< of the trajectory where the list's clock starts
  double tick_s = 0.002;
  double latency_s = 0.0;   ///< from a tick to liquid on the surface
  double volume_mm3 = 0.0;  ///< wanted of these pulses, together
  std::span<const std::int32_t> ticks;
};

/// Frame of the tool that laid it.
struct NozzleFrame {
  const motion::Arm& arm;
  motion::Tool tool;
  Point2 origin;  ///< of the part's frame in the arm's [mm]
};

/// Adds height [mm] = volume over area to the cells nearest to where the pulses fell, an equal share of the
/// volume each. Pulses beside the grid are left out. @throws std::invalid_argument: fewer axes than the arm
/// has joints
void add_laid(const FiredList& list, const NozzleFrame& frame, HeightMap& nominal_mm);

}  // namespace firn::flow
