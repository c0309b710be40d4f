// EdgeRays: the opacity along rays from a droplet's centre across its edge, and what their mean shows.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/vision/scene.h"

namespace firn::vision {

inline constexpr int kRays = 128;  ///< evenly spaced directions; a multiple of 8
template <class T>
using PerRay = std::array<T, std::size_t(kRays)>;

/// Edge spread that rays of reach 1 reach over [px]; a wider one needs a larger reach.
inline constexpr double kReachedBlur_px = 2.8;
/// Length of a ray of reach 1 on either side of the silhouette's edge [px]: 3.2 times kReachedBlur_px.
inline constexpr double kRayHalf_px = 9.0;

/// Unit vectors of the rays: by bisection, since square roots alone give the same bytes on every machine.
PerRay<Point> ray_directions();

struct Ray {
  double start_px = 0.0, step_px = 0.0;  ///< of the samples, from the centre
  std::vector<double> opacity;
  double rim = 0.0;            ///< largest mean of five samples from the inside to the silhouette's edge
  std::size_t rim_sample = 0;  ///< the middle one of these
  double ground = 0.0;         ///< mean of the outermost samples
  double at(std::size_t i) const { return start_px + step_px * double(i); }
};

/// Samples a ray of length `reach` * kRayHalf_px to either side of `radius_px`, in steps of `reach` / 2 px.
/// @param cell_px side of the silhouette's cells
Ray sample_ray(const Scene& scene, Point centre, Point direction, double radius_px, double cell_px,
               double reach);

/// Finds the first place outwards from the rim where the opacity falls halfway from `rim` to the ray's
/// ground. @returns false where it does not
bool find_halfway(const Ray& ray, double rim, double& radius_px);

/// Standard deviation of the edge spread function [px]: the integral of a Gaussian edge from its halfway
/// point outwards is s / sqrt(2 pi) of its height. The rays are averaged before it is taken, since it would
/// add up their noise. 0 where no ray is used.
/// @param edge halfway points of the rays
double edge_blur_px(const PerRay<Ray>& rays, const PerRay<double>& edge, const PerRay<bool>& use);

/// Opacity over the ground across the rim, averaged over the rays at equal distances from their edges.
struct MeanProfile {
  std::vector<double> opacity;  ///< empty: too few rays
  double first_px = 0.0, pitch_px = 0.0;
};
MeanProfile mean_profile(const PerRay<Ray>& rays, const PerRay<double>& edge, const PerRay<bool>& use);

/// The rays of `use` whose ground is saturated; none where objects are brighter than their ground.
PerRay<bool> saturated_rays(const Scene& scene, Point centre, const PerRay<Ray>& rays,
                            const PerRay<bool>& use);

}  // namespace firn::vision
