// A linear fit to heights of an uneven surface: near places share their unevenness, over a length that is not
// known.
#pragma once

#include <vector>

namespace firn::calibration {

struct UnevenDatum {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;
  std::vector<double> row;  ///< derivatives by the unknowns
};
struct UnevenFit {
  std::vector<double> value, variance;  ///< of the first unknowns
  double freedom = 0.0;
  double log_evidence = 0.0;  ///< Schwarz's [1978], to be compared between fits of the same data
};

/// Generalised least squares with correlations exp(-(distance / length)^2). Lengths from 0 to the mean
/// distance of a place from its nearest neighbour are taken for equally likely beforehand (a longer one would
/// show in the fit, few places tell a shorter one from none); each counts by its restricted likelihood, and
/// what the estimates differ by is part of the variance.
/// @param unknowns the first so many of the rows @param least_mm resolution of the heights @pre more data
/// than unknowns, which they determine
UnevenFit fit_uneven(const std::vector<UnevenDatum>& data, std::size_t unknowns, double least_mm);

}  // namespace firn::calibration
