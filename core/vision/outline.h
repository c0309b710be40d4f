// Outline measures the edge of one droplet between pixels: centroid, diameter, axes and their uncertainty.
#pragma once

#include "core/vision/bulges.h"

namespace firn::vision {

struct Outline {
  bool found = false;
  double x = 0.0, y = 0.0;                          ///< centroid of the area [px]
  double x_std = 0.0, y_std = 0.0;                  ///< [px]
  double diameter_px = 0.0, diameter_std_px = 0.0;  ///< of the circle of equal area
  double xx = 0.0, xy = 0.0, yy = 0.0;  ///< second central moments of the area, over the area [px^2]
  double blur_px = 0.0;                 ///< standard deviation of the edge spread function
  double opacity = 0.0;                 ///< of the rim's inside, median
  double roughness_px = 0.0;            ///< standard deviation of the edge points from the ellipse
  double covered = 0.0;                 ///< share of the circumference where the edge was seen
};

/// Standard deviation of a diameter that pictures of one focus share, from the edge's spread. A spread wider
/// than the rays of a droplet of this size reach is not known, and with it how far it moved the edge.
double blurred_std_px(double blur_px, double diameter_px);

/// Samples the opacity along 128 rays from the bulge's centre. Each edge point is where the opacity is
/// halfway between the ray's ground and its own rim, so that light and transparency may vary around the
/// droplet. An ellipse is fitted to the points, robustly; rays in which the edge is far from it (tail,
/// ligament, neighbour) take the ellipse's radius. A blur of standard deviation s moves the halfway point of
/// a disc of radius R inwards by s^2 / (2 R) (second order of the convolution of a disc with a Gaussian),
/// which is added.
Outline measure_outline(const Scene& scene, const Silhouette& silhouette, const Bulge& bulge);

/// Integrates the opacity of a small object: sum / `opaque` is its area, however blurred it is. Pixels
/// farther than 3 px from the component do not count.
Outline integrate_spot(const Scene& scene, const Component& component, double opaque);

/// The axis of the area along the unit vector u, as the ratio of full axes: along over across.
double axis_ratio(const Outline& outline, Point u);

}  // namespace firn::vision
