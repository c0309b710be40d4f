// weighted_bound() computes a lower bound for one layer with a deviation in its objective: alpha < 1 in
// Eq. (8) [Lu 2015], N = 1.
//
// J = alpha mean|e| + (1 - alpha) s, where m = mean(e) and s^2 = mean(e^2) - m^2 couple all cells. For any p
// and q a bound of the separable sum g(p, q) <= min mean(alpha |e| + p e + q e^2) is proved by strips
// (bound.h), so that every layer has
//   J >= g - p m - q (m^2 + s^2) + (1 - alpha) s,      J >= alpha |m| + (1 - alpha) s,
// for any m and s. The least value of the largest of these cuts over all (m, s) is a bound for J. It is found
// by bisecting rectangles: for q >= 0 a cut is concave in m and in s, least at a rectangle's corners. Where
// it is least the next cut is made, tangent to (1 - alpha) s there: q = (1 - alpha) / (2 s), p = -2 q m; the
// first one is made where a known layer lies.
#pragma once

#include <functional>
#include <vector>

#include "core/control/mpc/bound/bound.h"

namespace firn::control::mpc {

/// J >= base + slope_m m - square (m^2 + s^2) + (1 - alpha) s [mm]
struct MomentCut {
  double base = 0.0, slope_m = 0.0, square = 0.0;  ///< square >= 0
};

struct CutsMinimum {
  double bound_mm = 0.0;                     ///< no (m, s) has less, at most `tolerance_mm` below the least
  double mean_mm = 0.0, deviation_mm = 0.0;  ///< where it is least
};

/// Least value over |m| <= known / alpha, 0 <= s <= known / (1 - alpha) of the largest cut; outside J >=
/// known anyway.
/// @pre 0 < alpha < 1, known_mm > 0, tolerance_mm > 0
CutsMinimum minimum_of_cuts(const std::vector<MomentCut>& cuts, double alpha, double known_mm,
                            double tolerance_mm);

struct WeightedBoundOptions {
  BoundOptions strips{2, 12, 0.0, 1e-6};  ///< of each cut
  int cuts = 40;                          ///< at most
  double gap = 1e-4;                      ///< ends when (known - bound) / known is no larger
};

struct WeightedBound {
  double known_mm = 0.0;      ///< objective of the known layer
  double objective_mm = 0.0;  ///< no layer of at most one droplet per cell has a smaller objective
  int cuts = 0, sweeps = 0;
  std::vector<double> history_mm;  ///< bound after each cut
};

/// @param known a good layer, 0 or 1 per cell (weighted_layer.h): its objective limits the bound from above
/// @param watch called after each cut with the bound so far; may be empty
/// @pre 0 < alpha < 1. @throws std::invalid_argument: rows outside 1..4
WeightedBound weighted_bound(const Setup& setup, const HeightMap& height, const MaterialMap& materials,
                             double alpha, const DropletPattern& known, const WeightedBoundOptions& options,
                             const ParallelFor& parallel,
                             const std::function<void(double bound_mm)>& watch = {});

}  // namespace firn::control::mpc
