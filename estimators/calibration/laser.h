// Estimates the point laser's offset and latency from passes over a block with sharp edges [Barnett 2012,
// 5.2.1].
#pragma once

#include <optional>
#include <span>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/tool.h"
#include "core/path/path.h"
#include "estimators/calibration/robust_fit.h"

namespace firn::calibration {

/// A block on the table: its upright sides are the edges that a pass crosses. In the part's frame [mm].
struct Jig {
  double x0_mm = 0.0, y0_mm = 0.0, x1_mm = 0.0, y1_mm = 0.0;
};

/// One executed path with its readings (storage begun with the motion's signal).
struct LaserPass {
  Trajectory motion;
  double period_s = 0.01;
  std::vector<float> reading_mm;  ///< NaN = no value
};

struct LaserBelief {
  const motion::Arm& arm;
  motion::Tool laser;  ///< present estimate; may be wrong by `reach_mm`
  Point2 origin;       ///< of the part's frame in the arm's [mm]
  double latency_s = 0.0;
  double reach_mm = 5.0, bound_s = 0.2;
};

enum class LaserUnknowns { kOffset, kLatency };

struct LaserCalibration {
  Estimate x_mm, y_mm;  ///< of the spot in the flange's frame
  Estimate latency_s;   ///< of reading 0 after the motion began
  std::optional<Estimate> block_x_mm,
      block_y_mm;  ///< the block's place beyond the jig's; where passes of two yaws determine it
  int edges = 0;   ///< crossings used
  FitResult fit;
  struct Crossed {
    double speed_mm_s, off_mm;  ///< signed; of the fit
    bool along_x;
  };
  std::vector<Crossed> residuals;
};

/// Passes should differ in speed or start, so that readings fall differently on the sides. A crossing is
/// where readings step through the middle between the levels on both sides. At crossing time t the spot is on
/// the edge: n (p(t + latency) + offset) = c. The sign of the step and the arm's direction identify the side,
/// so a wrong offset does not confuse them. Both offsets and the latency are fitted together (an offset alone
/// would take the latency's place): that needs passes both ways over sides in x and in y. The offset turns
/// with the flange's yaw, which is read off the joints; passes of yaws 60 degrees apart or more separate it
/// from the block's place as well, which is then fitted too. kLatency: the place of the block is unknown;
/// passes of one yaw both ways over sides in one direction are enough, and only latency_s is estimated.
/// @throws Unidentifiable: no step, too few crossings, no passes both ways, sides of one direction only
/// (kOffset), a yaw that turns along a pass, yaws that differ (kLatency), more than a quarter of the steps
/// off the sides
LaserCalibration calibrate_laser(std::span<const LaserPass> passes, const Jig& jig, const LaserBelief& belief,
                                 LaserUnknowns parameters);

}  // namespace firn::calibration
