// RimFit and ClippedEdge compute the true edge of a blurred droplet from the opacity across it.
#pragma once

#include <span>

namespace firn::vision {

/// A rim that is thin against its blur, as of a droplet out of focus with a bright middle, stays paler than
/// its liquid, and its halfway point lies outside of its edge.
struct RimFit {
  bool found = false;
  double edge_px = 0.0;   ///< from the origin of the profile, outwards
  double blur_px = 0.0;   ///< standard deviation of both edges' spread
  double width_px = 0.0;  ///< from the bright middle to the edge
  double level = 0.0;     ///< opacity of the liquid
};

/// Fits A F((e - d) / s) - B F((e - w - d) / s), F the normal distribution, to opacities at distances
/// d = first_px + k pitch_px from an origin, outwards, by damped Gauss-Newton steps; A is near 1, the opacity
/// of liquid, if the profile does not say otherwise. Not found: the rim reaches its plateau, or the profile
/// is no rim.
/// @param blur_px a first guess
RimFit fit_rim(std::span<const double> opacity, double first_px, double pitch_px, double blur_px);

/// Before a saturated ground the halfway point lies inside of the edge: the light that the sensor cut off is
/// missing in the contrast.
struct ClippedEdge {
  bool found = false;
  double edge_px = 0.0;  ///< from the origin of the profile, outwards
  double edge_std_px = 0.0;
  double blur_px = 0.0;  ///< standard deviation of the edge spread
};

/// Fits A max(0, (1 + c) F((e - d) / s) - c), F the normal distribution, to opacities at distances
/// d = first_px + k pitch_px from an origin, outwards, from their peak on. Not found: the profile has another
/// shape, or the light is more than four times too strong.
/// @param blur_px a first guess
ClippedEdge fit_clipped_edge(std::span<const double> opacity, double first_px, double pitch_px,
                             double blur_px);

}  // namespace firn::vision
