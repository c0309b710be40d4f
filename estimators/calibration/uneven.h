// Estimates a linear model of heights on an uneven surface by generalised least squares: the unevenness of
// near places is correlated over an unknown length.
#pragma once

#include <vector>

namespace firn::calibration {

struct UnevenDatum {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;
  std::vector<double> row;  ///< derivatives by the parameters
};
struct UnevenFit {
  std::vector<double> value, variance;  ///< of the first parameters
  double freedom = 0.0;
  double log_evidence = 0.0;  ///< Schwarz's [1978], to be compared between fits of the same data
};

/// Generalised least squares with correlations exp(-(distance / length)^2). Lengths from 0 to the mean
/// distance of a place from its nearest neighbour have equal prior probability (a longer one would show in
/// the fit, few places distinguish a shorter one from 0); each counts by its restricted likelihood, and the
/// spread of the estimates is part of the variance.
/// @param parameters the first so many of the rows @param min_mm resolution of the heights @pre more data
/// than parameters, which they determine
UnevenFit fit_uneven(const std::vector<UnevenDatum>& data, std::size_t parameters, double min_mm);

}  // namespace firn::calibration
