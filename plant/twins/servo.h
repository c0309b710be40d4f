// Servo computes the motion of two axes that follow a planned track through position loops of limited
// bandwidth.
#pragma once

#include <array>
#include <vector>

#include "plant/record/archive.h"
#include "plant/twins/track.h"

namespace firn::plant {

/// One axis as a damped oscillator behind the plan r: x'' = w^2 (r - x) + 2 d w (f r' - x'), w = 2 pi hz. f
/// is the share of the velocity that is fed forward: (1 - f) 2 d / w is the lag of a steady motion, r'' / w^2
/// the error of a steady acceleration.
struct ServoAxis {
  double hz = 60.0, damping = 0.7, feed_forward = 0.9;
};

/// Track as followed, and how long it may be believed.
struct Following {
  std::vector<TrackKnot> knots;  ///< dense, times as those of the plan
  double settled_s = 0.0;        ///< from then on it stands at the plan's end
  std::array<double, 2> too_far_s{1e300,
                                  1e300};  ///< first time at which an axis is beyond the permitted error
};

/// Continues from `begin`, a state of the axes at a time of the plan, until they stand. Integrates by
/// Runge-Kutta's fourth order in steps of 0.5 ms.
Following follow_plan(const Track& plan, const std::array<ServoAxis, 2>& axes, const TrackKnot& begin,
                      double position_error_mm);

}  // namespace firn::plant
