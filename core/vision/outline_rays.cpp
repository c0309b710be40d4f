#include "core/vision/outline_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered pictures (tests/bench/droplet_pictures.cpp, seeds
// below 50,000).
constexpr double kRayStep_px = 0.5;        // half of the bilinear kernel's width
constexpr double kMaxInwardsShare = 0.7;   // of the radius: rays stay clear of the centre, where they crowd
constexpr std::size_t kRimHalf = 2;        // samples to either side in a mean of the rim: 2 px in all
constexpr std::size_t kGroundSamples = 6;  // outermost ones of a ray: 3 px
constexpr double kMaxGround = 0.2;         // opacity; a darker one belongs to a neighbour and is taken as 0
constexpr double kSaturatedShare = 0.75;   // of a ray's ground samples that are white
constexpr int kBlurSamples = 20;           // of the edge spread's integral, half a ray's step apart: 5 px
constexpr int kProfileIn = 18, kProfileOut = 12;  // steps of the mean profile to either side of the edge
constexpr int kMinProfileRays = kRays / 4;        // of its place that most rays reach

// Linear between the samples. @pre the place lies between them
double opacity_at(const Ray& ray, double sample) {
  const std::size_t j = std::size_t(sample);
  return (1 - (sample - double(j))) * ray.opacity[j] + (sample - double(j)) * ray.opacity[j + 1];
}

}  // namespace

PerRay<Point> ray_directions() {
  PerRay<Point> d{};
  d[0] = {1, 0};
  d[kRays / 4] = {0, 1};
  d[kRays / 2] = {-1, 0};
  d[3 * kRays / 4] = {0, -1};
  for (int step = kRays / 8; step >= 1; step /= 2)
    for (int k = step; k < kRays; k += 2 * step) {
      const Point a = d[std::size_t(k - step)], b = d[std::size_t((k + step) % kRays)];
      const double x = a.x + b.x, y = a.y + b.y, n = std::sqrt(x * x + y * y);
      d[std::size_t(k)] = {x / n, y / n};
    }
  return d;
}

Ray sample_ray(const Scene& scene, Point c, Point u, double radius_px, double cell_px, double reach) {
  Ray ray;
  const double half = reach * kRayHalf_px + cell_px, in = std::min(half, kMaxInwardsShare * radius_px);
  ray.start_px = radius_px - in;
  ray.step_px = reach * kRayStep_px;
  for (double d = -in; d <= half; d += ray.step_px)
    ray.opacity.push_back(scene.opacity(c.x + u.x * (radius_px + d), c.y + u.y * (radius_px + d)));
  const std::size_t n = ray.opacity.size(),
                    edge = std::min(n - 1, std::size_t((in + cell_px) / ray.step_px) + kRimHalf);
  for (std::size_t i = 0; i <= edge; ++i) {
    double sum = 0.0;
    int m = 0;
    for (std::size_t j = i >= kRimHalf ? i - kRimHalf : 0; j <= std::min(n - 1, i + kRimHalf); ++j, ++m)
      sum += ray.opacity[j];
    if (sum / m > ray.rim) {
      ray.rim = sum / m;
      ray.rim_sample = i;
    }
  }
  double ground = 0.0;
  for (std::size_t i = n - kGroundSamples; i < n; ++i) ground += ray.opacity[i] / kGroundSamples;
  ray.ground = ground < kMaxGround ? ground : 0.0;
  return ray;
}

bool find_halfway(const Ray& ray, double rim, double& radius_px) {
  const double half = 0.5 * (rim + ray.ground);
  for (std::size_t i = ray.rim_sample; i + 2 < ray.opacity.size(); ++i) {
    if (ray.opacity[i] < half || ray.opacity[i + 1] >= half || ray.opacity[i + 2] >= half) continue;
    radius_px = ray.at(i) + ray.step_px * (ray.opacity[i] - half) / (ray.opacity[i] - ray.opacity[i + 1]);
    return true;
  }
  return false;
}

double edge_blur_px(const PerRay<Ray>& rays, const PerRay<double>& edge, const PerRay<bool>& use) {
  const double pitch = 0.5 * rays[0].step_px;
  std::array<double, kBlurSamples> mean{};
  int n = 0;
  for (int k = 0; k < kRays; ++k) {
    if (!use[k]) continue;
    const Ray& ray = rays[k];
    const double height = ray.rim - ray.ground, last = ray.at(ray.opacity.size() - 2);
    if (height <= 0 || edge[k] + kBlurSamples * pitch > last) continue;
    ++n;
    for (int i = 0; i < kBlurSamples; ++i)
      mean[i] +=
          (opacity_at(ray, (edge[k] + (i + 0.5) * pitch - ray.start_px) / ray.step_px) - ray.ground) / height;
  }
  if (n == 0) return 0.0;
  double sum = 0.0;
  for (const double m : mean) sum += std::max(0.0, m / n) * pitch;
  return sum * std::sqrt(2 * std::numbers::pi);
}

MeanProfile mean_profile(const PerRay<Ray>& rays, const PerRay<double>& edge, const PerRay<bool>& use) {
  const double pitch = rays[0].step_px;
  std::array<double, kProfileIn + kProfileOut + 1> mean{};
  std::array<int, kProfileIn + kProfileOut + 1> n{};
  for (int k = 0; k < kRays; ++k) {
    if (!use[k]) continue;
    const Ray& ray = rays[k];
    for (int i = -kProfileIn; i <= kProfileOut; ++i) {
      const double at = (edge[k] + i * pitch - ray.start_px) / ray.step_px;
      if (at < 0.0 || at + 1.0 >= double(ray.opacity.size())) continue;
      mean[std::size_t(i + kProfileIn)] += opacity_at(ray, at) - ray.ground;
      ++n[std::size_t(i + kProfileIn)];
    }
  }
  const int most = *std::ranges::max_element(n);
  int first = 0, last = kProfileIn + kProfileOut;
  while (first < last && 2 * n[std::size_t(first)] < most) ++first;
  while (last > first && 2 * n[std::size_t(last)] < most) --last;
  MeanProfile profile{{}, (first - kProfileIn) * pitch, pitch};
  if (most < kMinProfileRays) return profile;
  for (int i = first; i <= last; ++i) profile.opacity.push_back(mean[std::size_t(i)] / n[std::size_t(i)]);
  return profile;
}

PerRay<bool> saturated_rays(const Scene& scene, Point c, const PerRay<Ray>& rays, const PerRay<bool>& use) {
  const auto u = ray_directions();
  const Frame& f = scene.frame();
  PerRay<bool> saturated{};
  if (scene.illumination().inverted) return saturated;
  for (int k = 0; k < kRays; ++k) {
    int white = 0;
    for (std::size_t i = rays[k].opacity.size() - kGroundSamples; i < rays[k].opacity.size(); ++i) {
      const int x = std::clamp(int(c.x + u[k].x * rays[k].at(i) + 0.5), 0, f.width - 1),
                y = std::clamp(int(c.y + u[k].y * rays[k].at(i) + 0.5), 0, f.height - 1);
      white += f.at(x, y) >= f.white;
    }
    saturated[k] = use[k] && white >= kSaturatedShare * kGroundSamples;
  }
  return saturated;
}

}  // namespace firn::vision
