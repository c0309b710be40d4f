// Estimates the surface on a grid from the readings of a point laser along executed trajectories.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/tool.h"
#include "core/path/path.h"
#include "estimators/surface/scattered_surface.h"

namespace firn::surface {

/// Frame of the laser's focus while a path is run.
struct LaserFrame {
  const motion::Arm& arm;
  motion::Tool laser;  ///< its focus at the reference distance, in the flange's frame
  Point2 origin;       ///< of the part's frame in the arm's [mm]
  double origin_z_mm = 0.0;
  double latency_s = 0.0;  ///< reading k was taken latency + k period after the motion began [5.2.1]
};

struct ReadingCounts {
  std::int64_t taken = 0;    ///< during the motion
  std::int64_t invalid = 0;  ///< of them: NaN
  std::int64_t spikes = 0;   ///< of them: valid, but off their neighbours
};

/// Appends one point per valid reading that was taken during the motion: (x, y) of the laser's focus in the
/// part's frame, z of the focus plus the reading. The joints are linear between ticks. A reading that lies
/// more than max(0.05 mm, 4 standard deviations by the median) off the median of the seven about it is a
/// spike and left out.
/// @throws std::invalid_argument: fewer axes than the arm has joints, a period that is not above 0
ReadingCounts add_readings(const Trajectory& executed, const LaserFrame& frame, double period_s,
                           std::span<const float> reading_mm, std::vector<SurfacePoint>& points);

/// Noise of one reading, from the second differences of neighbours in order [mm]; 0 with fewer than 16.
double noise_of_readings(std::span<const SurfacePoint> points);

struct ScatterOptions {
  double reach_mm = 3.0;  ///< a cell with no reading so near counts as not measured
  bool smooth = true;     ///< robust_smoothing.h over the measured cells of the footprint
  int samples = 1;        ///< a cell's height is the mean over so many places a side; 1 = its centre's
};

struct ScatterEstimate {
  HeightMap height;               ///< finite everywhere unless there is no reading at all
  Grid<std::uint8_t> quality;     ///< CellQuality: measured = on the footprint and within reach of a reading
  double noise_std_mm = 0.0;      ///< of one reading
  double covered_fraction = 0.0;  ///< of the footprint's cells: measured
};

/// @throws std::invalid_argument: the footprint is not on the grid
ScatterEstimate estimate_surface(const GridSpec& grid, const Mask& footprint,
                                 std::span<const SurfacePoint> points, const ScatterOptions& options);

}  // namespace firn::surface
