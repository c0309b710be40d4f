// round_corner() computes a corner rounded at constant speed: equal parabolic blends whose speeds turn step
// by step from one direction to the next, each at the stage's full acceleration.
#pragma once

#include <vector>

#include "core/motion/aerosol/plan.h"

namespace firn::motion {

/// n blends over the turn phi: each turns the speed by psi = phi / n and lasts 2 v sin(psi/2) / alpha, at
/// acceleration alpha along its chord. n is even and psi <= 0.05 rad, so that the speed dips by 1 -
/// cos(psi/2) < 0.04 %. The blends leave the first segment and join the second at v^2/alpha cos(psi/2)
/// tan(phi/2) from the corner.
struct Rounding {
  double tangent_mm = 0.0;    ///< from the corner to either end of the blends
  double deviation_mm = 0.0;  ///< from the corner to the middle of the blends: the largest of the path
  double duration_s = 0.0;
  std::vector<Piece> pieces;  ///< times from 0, positions relative to the corner; segment not set
};

/// @param from, to unit vectors of the two segments; not opposite. Equal ones give no pieces.
Rounding round_corner(const Point2& from, const Point2& to, double speed_mm_s, double alpha_mm_s2);

}  // namespace firn::motion
