// RobustSmoother estimates a smooth height map from one with missing values and outliers, with an automatic
// amount of smoothing. Source: D. Garcia, "Robust smoothing of gridded data in one and higher dimensions with
// missing values", Computational Statistics & Data Analysis 54 (2010) 1167-1178, doi
// 10.1016/j.csda.2009.09.020, and its code smoothn.
//
// Minimises  || sqrt(W) (y - z) ||^2 + s || D z ||^2,  D the second difference with mirrored borders, by
//   z <- IDCT( Gamma DCT( W (y - z) + z ) ),   Gamma = 1 / (1 + s lambda^2),
//   lambda_ij = 2 (cos(i pi / nx) - 1) + 2 (cos(j pi / ny) - 1);
// s minimises the generalised cross-validation score; after each solution the residuals give bisquare
// weights.
#pragma once

#include <memory>

#include "core/grid/grid.h"

namespace firn::surface {

struct SmoothingOptions {
  double s = 0.0;  ///< amount of smoothing; 0: automatic (s between 8e-4 and 1.6e10, in steps of 2^(1/4))
  bool robust = true;
  int robust_steps = 3;  ///< re-weightings
  /// Of the fixed point, per re-weighting. It stops earlier when z moves by less than `tolerance` times the
  /// standard deviation of the data (root mean square over cells with weight).
  int max_iterations = 30;
  double tolerance = 1e-3;
};

struct Smoothed {
  HeightMap height;  ///< z, finite everywhere
  double s = 0.0;
  Grid<double> weights;       ///< W of the last step: bisquare, 0 where y is missing
  double noise_std_mm = 0.0;  ///< of the residuals y - z, by their median deviation, corrected for the fit
  int iterations = 0;         ///< together
};

/// For maps of one size; keeps transforms and workspace.
class RobustSmoother {
 public:
  explicit RobustSmoother(const GridSpec& grid);
  ~RobustSmoother();
  RobustSmoother(RobustSmoother&&) noexcept;

  /// `height`: NaN = missing. `weights`: 0..1 per cell, or nullptr for 1 everywhere. A missing value starts
  /// from its nearest known one. With fewer than three known cells the known mean is returned with s = 0.
  /// @throws std::invalid_argument: sizes differ, a weight outside 0..1, s negative or not finite.
  Smoothed smooth(const HeightMap& height, const Grid<double>* weights, const SmoothingOptions& options);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace firn::surface
