// Estimates the spacing of droplets, L = gamma d [Lu 2015, Eq. (1)], from prints: "consistent height for any
// n x n matrix droplet layout" [V-C], smooth without much overlap [III-A].
#pragma once

#include <vector>

#include "core/grid/grid.h"
#include "estimators/droplet/surface_filter.h"

namespace firn::droplet {

/// A printed square: n x n droplets, `step` cells apart, from cell (i, j) on.
struct Square {
  int i = 0, j = 0, n = 1, step = 1;
};

/// Rise of the cells between and under the outermost droplets of one square.
struct SquareRise {
  int n = 1;
  double mean_mm = 0.0;
  double square_mm2 = 0.0;  ///< mean of the squares
  double ripple_mm = 0.0;   ///< mean under droplets less mean half way between them; 0 for n = 1 or step 1
};
/// Squares with a cell that was not measured are left out.
std::vector<SquareRise> square_rises(const HeightMap& before, const HeightMap& after,
                                     const std::vector<Use>& use, const std::vector<Square>& squares);

/// Result of one spacing.
struct SpacingResult {
  double gamma = 0.0;
  std::vector<double> mean_mm;  ///< by n, from n = 2 on: index 0 is n = 2
  std::vector<int> repeats;     ///< of each
  double height_mm = 0.0;       ///< mean of mean_mm
  double between_sizes = 0.0;   ///< standard deviation of mean_mm over n, relative to height_mm
  double within = 0.0;          ///< of the heights inside a square, noise taken off, relative
  double inconsistency = 0.0;   ///< root of the sum of both squares: the quantity to minimise
  double std_error = 0.0;       ///< of inconsistency, by leaving out one repeat after the other (jackknife)
};
/// @param noise_std_mm of one rise; squares of one droplet are left out, for they have nothing to be
/// consistent with.
/// @throws std::invalid_argument: fewer than two sizes of two droplets or more, or a height that is not above
/// 0.
SpacingResult evaluate_spacing(double gamma, const std::vector<SquareRise>& squares, double noise_std_mm);

struct SpacingChoice {
  double gamma = 0.0;      ///< vertex of the parabola through the smallest and its neighbours
  double std_error = 0.0;  ///< from those of the three
  std::size_t best = 0;    ///< index of the smallest
  bool inside = false;     ///< not at an end of the tried spacings
};
/// @param results ascending in gamma, at least three. @throws std::invalid_argument
SpacingChoice choose_spacing(const std::vector<SpacingResult>& results);

}  // namespace firn::droplet
