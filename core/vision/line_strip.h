// Strip holds samples of a picture along and across a wanted line, as levels, then as contrasts.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/vision/line_picture.h"

namespace firn::vision {

inline constexpr double kUnread = std::numeric_limits<double>::quiet_NaN();

/// Row a lies along the wanted line, column c across it.
struct Strip {
  int rows = 0, columns = 0;
  double first_along_px = 0.0, first_across_px = 0.0;  ///< of row 0 and column 0; 1 px apart
  std::vector<double> value;                           ///< NaN beside the picture
  double saturated = 0.0;                              ///< share of the samples
  double interpolation = 0.0;                          ///< variance of the blur that sampling added [px^2]

  double& at(int a, int c) { return value[std::size_t(a) * std::size_t(columns) + std::size_t(c)]; }
  double at(int a, int c) const { return value[std::size_t(a) * std::size_t(columns) + std::size_t(c)]; }
  double across_px(double c) const { return first_across_px + c; }
};

/// Bilinear samples, 1 px apart; along an axis of the picture they are its pixels, which interpolation would
/// blur.
/// @param flat divides the levels, or nullptr
Strip sample_strip(const Frame& picture, const Frame* flat, const LineView& view);

/// Turns levels into contrasts, against a quadric through the far columns (a plane over a flat field).
/// @returns the standard deviation of the ground's level, relative; nothing where too little of it is seen
std::optional<double> to_contrast(Strip& strip, bool flat);

/// Standard deviation of one sample, from differences of rows two apart.
double pixel_noise(const Strip& strip);

/// Mean of each column over the rows in use; NaN where there is none.
std::vector<double> mean_profile(const Strip& strip, const std::vector<int>& rows);

/// The profile before a blur of this variance [px^2], to second order.
std::vector<double> deblurred(const std::vector<double>& profile, double variance);

}  // namespace firn::vision
