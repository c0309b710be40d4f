// SweepResult holds a jet's velocity, angle, droplet size and break-off, each with its standard deviation,
// from pictures at several strobe delays.
#pragma once

#include <span>
#include <vector>

#include "core/vision/droplets.h"

namespace firn::vision {

/// `known` is false where the pictures do not determine it. value +- 1.96 std covers 95 %.
struct Estimate {
  double value = 0.0, std = 0.0;
  bool known = false;
};

struct Scale {
  double um_per_px = 0.0, std = 0.0;
};

/// From the known width of the nozzle: mean of the pictures that show it. 0 when none does.
Scale scale_from_nozzle(std::span<const DropletPicture> pictures, double nozzle_um);
/// From a picture of a target of equal round dots in a square lattice: the median distance of neighbours is
/// the pitch. 0 for fewer than 9 dots.
Scale scale_from_target(const DropletPicture& target, double pitch_um);

struct TimedPicture {
  double delay_us = 0.0;
  DropletPicture picture;
};

struct SweepResult {
  int pictures = 0, with_droplet = 0, used = 0;
  double middle_us =
      0.0;  ///< mean delay of the pictures used; the velocity holds there, since air slows a droplet
  Estimate velocity_m_s;
  Estimate angle_deg;  ///< from the nozzle's axis (else from the picture's downward axis), positive towards
                       ///< +x of a jet that flies down
  Estimate diameter_um, volume_pl;
  Estimate satellites;  ///< median number in a picture of a free droplet
  Estimate largest_satellite_um;
  Estimate break_off_us;  ///< between the last delay that shows a ligament and the first that does not
  Estimate jitter_us;     ///< standard deviation of the droplet's place along the flight, as time
  Point flight;           ///< unit vector [px]
};

/// Weighted least squares lines x(t), y(t) through the centroids of free droplets, robust against a picture
/// whose main droplet is another one. Variances are those of the pictures plus that of the jitter, which is
/// what the residuals along the flight exceed them by. With few pictures the residuals count beside the
/// stated variances, in proportion to their number (inverse-gamma prior, 8 degrees of freedom).
/// @param pictures in any order; equal delays are allowed
SweepResult measure_sweep(std::span<const TimedPicture> pictures, const Scale& scale);

/// Arc tangent by argument halving and its series: square roots and divisions alone, relative error below
/// 1e-13.
double arc_tangent(double x);

}  // namespace firn::vision
