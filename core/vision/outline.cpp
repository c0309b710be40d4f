#include "core/vision/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/statistics/median.h"
#include "core/vision/least_squares.h"
#include "core/vision/outline_rays.h"
#include "core/vision/rim.h"

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered pictures (tests/bench/droplet_pictures.cpp, seeds
// below 50,000); "share" is a share of the droplet's radius.

// Fit of an ellipse: 5 unknowns.
constexpr std::size_t kMinConicRays = 24;
constexpr double kMinFirstRadius = 0.5, kMaxFirstRadius = 1.35;  // of the median radius: tails stay out
constexpr int kConicRounds = 8;
constexpr double kMaxConicRadius = 3.0;  // of the median radius: a longer one is a fit that diverges
constexpr double kTukeyStds = 3.0;       // where a point's weight reaches 0
constexpr double kMinTukeyShare = 0.01, kMinTukey_px = 0.05;

// Distance from the ellipse within which an edge is the droplet's own, not a tail's or a neighbour's.
constexpr double kCoarseShare = 0.12, kCoarseCells = 1.5, kCoarse_px = 1.0;  // of the silhouette's edge
constexpr double kFineStds = 4.0, kFineShare = 0.03, kFine_px = 0.3;         // of the halfway points

// Level of the rim. That of a small blurred droplet does not reach its plateau; liquid refracts all light
// away there, as opaque objects do, so their level is taken instead: fully below kMinPlateau_px in diameter,
// not above kMaxPlateau_px, and never where the rim is paler than kMinOpaqueRim.
constexpr double kMinPlateau_px = 14.0, kMaxPlateau_px = 24.0;
constexpr double kMinOpaqueRim = 0.75;
constexpr int kRimRays = 4;  // to either side whose median is a ray's rim: noise, not the light, is averaged

constexpr int kMinEdgeRays = kRays / 4;  // of the halfway points on the ellipse, and of saturated grounds
constexpr double kSaturatedBlurs = 0.5;  // std of an edge before a saturated ground that is not fitted

// Standard deviations.
constexpr double kIndependent_px = 1.5;  // along the circumference: nearer edge points share their noise
constexpr double kMinIndependent = 4.0;  // points
constexpr double kUnseenShare = 0.02;    // where the edge is covered, the ellipse errs by so much
constexpr double kSystematic_px = 0.03;  // pixel grid, interpolation, compression: averaging leaves it
constexpr double kCentroid_px = 0.008;   // of it, what opposite sides do not share
constexpr double kCentroidFactor = 1.2;  // variance of a centroid over that of the mean radius
// Out of focus the plateaus and the ground of the rays lie in the tails of the blur: (blur - free)^2 times
// kBlurred_per_px is the std of a diameter, measured on drawn discs of 16 to 120 px.
constexpr double kBlurFree_px = 1.5, kBlurred_per_px = 0.025;
constexpr double kUnreachedBlurs = 0.5;  // std of a diameter whose blur is wider than its rays reach

// A conic a x^2 + b x y + c y^2 + d x + e y = 1 around the centre of the rays.
struct Conic {
  std::array<double, 5> c{};
  bool valid = false;

  /// The positive root along a direction; 0 if there is none.
  double radius(Point u) const {
    const double a = c[0] * u.x * u.x + c[1] * u.x * u.y + c[2] * u.y * u.y, b = c[3] * u.x + c[4] * u.y;
    const double root = b * b + 4 * a;
    if (!valid || root < 0 || a <= 0) return 0.0;
    return (-b + std::sqrt(root)) / (2 * a);
  }
};

// Iteratively reweighted with Tukey's biweight of the radial distance from the ellipse before.
Conic fit_conic(const PerRay<double>& r, const PerRay<bool>& use) {
  const auto u = ray_directions();
  Conic conic;
  std::vector<double> radii, off;
  for (int k = 0; k < kRays; ++k)
    if (use[k]) radii.push_back(r[k]);
  if (radii.size() < kMinConicRays) return conic;
  const double scale = statistics::median(radii);
  PerRay<double> weight{};
  for (int k = 0; k < kRays; ++k)
    weight[k] = use[k] && r[k] < kMaxFirstRadius * scale && r[k] > kMinFirstRadius * scale ? 1.0 : 0.0;
  for (int round = 0; round < kConicRounds; ++round) {
    SmallLeastSquares<5> sums;
    for (int k = 0; k < kRays; ++k) {
      const double x = u[k].x * r[k] / scale, y = u[k].y * r[k] / scale;
      if (weight[k] > 0) sums.add({x * x, x * y, y * y, x, y}, 1.0, weight[k]);
    }
    std::array<double, 5> c{};
    if (!sums.solve(c)) return conic;
    const double s2 = scale * scale;
    const Conic next{{c[0] / s2, c[1] / s2, c[2] / s2, c[3] / scale, c[4] / scale}, true};
    off.clear();
    PerRay<double> distance{};
    for (int k = 0; k < kRays; ++k) {
      const double e = next.radius(u[k]);
      if (e <= 0.0 || e > kMaxConicRadius * scale) return conic;
      distance[k] = std::abs(r[k] - e);
      if (use[k]) off.push_back(distance[k]);
    }
    conic = next;
    const double limit = std::max(kTukeyStds * statistics::kMadToStd * statistics::median(off),
                                  kMinTukeyShare * scale + kMinTukey_px);
    for (int k = 0; k < kRays; ++k) {
      const double q = distance[k] / limit;
      weight[k] = use[k] && q < 1 ? (1 - q * q) * (1 - q * q) : 0.0;
    }
  }
  return conic;
}

void measure_polygon(const PerRay<double>& r, Point centre, Outline& o) {
  const auto u = ray_directions();
  double area = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (int k = 0; k < kRays; ++k) {
    const int next = (k + 1) % kRays;
    const double x0 = u[k].x * r[k], y0 = u[k].y * r[k], x1 = u[next].x * r[next], y1 = u[next].y * r[next];
    const double cross = x0 * y1 - x1 * y0;
    area += cross / 2;
    sx += cross * (x0 + x1) / 6;
    sy += cross * (y0 + y1) / 6;
    sxx += cross * (x0 * x0 + x0 * x1 + x1 * x1) / 12;
    syy += cross * (y0 * y0 + y0 * y1 + y1 * y1) / 12;
    sxy += cross * (x0 * y1 + 2 * x0 * y0 + 2 * x1 * y1 + x1 * y0) / 24;
  }
  // A polygon in a circle lacks (2 pi / n)^2 / 6 of its area.
  constexpr double kPolygon = 1 + 4 * std::numbers::pi * std::numbers::pi / (6.0 * kRays * kRays);
  const double cx = sx / area, cy = sy / area;
  o.x = centre.x + cx;
  o.y = centre.y + cy;
  o.xx = sxx / area - cx * cx;
  o.xy = sxy / area - cx * cy;
  o.yy = syy / area - cy * cy;
  o.diameter_px = 2 * std::sqrt(area * kPolygon / std::numbers::pi);
}

// Distance of the silhouette's border from a place, along each ray.
PerRay<double> silhouette_radii(const Silhouette& s, Point c) {
  const auto u = ray_directions();
  const double step = 0.5 * s.scale;
  PerRay<double> radius{};
  for (int k = 0; k < kRays; ++k) {
    double d = 0.0;
    while (s.at(int(std::floor((c.x + u[k].x * d + 0.5 - s.x0) / s.scale)),
                int(std::floor((c.y + u[k].y * d + 0.5 - s.y0) / s.scale))))
      d += step;
    radius[k] = std::max(1.0, d - 0.5 * step);
  }
  return radius;
}

// Where the opacity along a ray is halfway between its ground and the rim.
struct HalfwayEdge {
  PerRay<double> radius{};
  PerRay<bool> use{};       // the edge was found near the silhouette's ellipse
  std::vector<double> rim;  // opacity of the rim around each ray that meets the silhouette there
};

HalfwayEdge find_halfway_edge(const PerRay<Ray>& rays, const PerRay<bool>& on_silhouette, const Conic& coarse,
                              double tolerance_px, double diameter_px) {
  const auto u = ray_directions();
  HalfwayEdge edge;
  std::vector<double> near;
  for (const Ray& ray : rays) near.push_back(ray.rim);
  const double rim = statistics::median(near);
  const double small =
      std::clamp((kMaxPlateau_px - diameter_px) / (kMaxPlateau_px - kMinPlateau_px), 0.0, 1.0);
  const double lift = rim > kMinOpaqueRim && rim < 1.0 ? small * (1.0 - rim) : 0.0;
  for (int k = 0; k < kRays; ++k) {
    if (!on_silhouette[k]) continue;
    near.clear();
    for (int d = -kRimRays; d <= kRimRays; ++d)
      near.push_back(rays[std::size_t((k + d + kRays) % kRays)].rim);
    edge.rim.push_back(statistics::median(near) + lift);
    edge.use[k] = find_halfway(rays[k], edge.rim.back(), edge.radius[k]) &&
                  std::abs(edge.radius[k] - coarse.radius(u[k])) < tolerance_px;
  }
  return edge;
}

// Spread of the edge, and how far its true place is from the halfway points.
struct EdgeShape {
  double blur_px = 0.0;
  double shift_px = 0.0;      // outwards
  double shift_std_px = 0.0;  // before a saturated ground
};

EdgeShape measure_edge_shape(const Scene& scene, Point c, const PerRay<Ray>& rays, const HalfwayEdge& edge) {
  EdgeShape shape;
  shape.blur_px = edge_blur_px(rays, edge.radius, edge.use);
  const auto of_thin_rim = [&] {
    const MeanProfile p = mean_profile(rays, edge.radius, edge.use);
    return p.opacity.empty() ? RimFit{} : fit_rim(p.opacity, p.first_px, p.pitch_px, shape.blur_px);
  };
  const RimFit rim = of_thin_rim();
  if (rim.found) {
    shape.blur_px = rim.blur_px;
    shape.shift_px = rim.edge_px;
  }
  const PerRay<bool> saturated = saturated_rays(scene, c, rays, edge.use);
  if (std::ranges::count(saturated, true) < kMinEdgeRays) return shape;
  ClippedEdge cut;
  if (!rim.found) {
    const MeanProfile p = mean_profile(rays, edge.radius, saturated);
    if (!p.opacity.empty()) cut = fit_clipped_edge(p.opacity, p.first_px, p.pitch_px, shape.blur_px);
  }
  if (cut.found) {
    shape.blur_px = cut.blur_px;
    shape.shift_px = cut.edge_px;
  }
  shape.shift_std_px = cut.found ? cut.edge_std_px : kSaturatedBlurs * shape.blur_px;
  return shape;
}

// The true edge: rays whose halfway point is far from the ellipse (tail, ligament, neighbour) take the
// ellipse's radius.
struct TrueEdge {
  PerRay<double> radius{};
  int seen = 0;               // rays that keep their own
  double roughness_px = 0.0;  // of these, from the ellipse
};

TrueEdge place_edge(const HalfwayEdge& edge, const Conic& fine, const EdgeShape& shape, double radius_px) {
  const auto u = ray_directions();
  std::vector<double> off;
  for (int k = 0; k < kRays; ++k)
    if (edge.use[k]) off.push_back(std::abs(edge.radius[k] - fine.radius(u[k])));
  const double spread = statistics::kMadToStd * statistics::median(off);
  const double limit = std::max({kFineStds * spread, kFineShare * radius_px, kFine_px});
  TrueEdge placed;
  double square = 0.0;
  for (int k = 0; k < kRays; ++k) {
    const double e = fine.radius(u[k]);
    double r = e;
    if (edge.use[k] && std::abs(edge.radius[k] - e) < limit) {
      r = edge.radius[k];
      square += (r - e) * (r - e);
      ++placed.seen;
    }
    r += shape.shift_px;
    // Second order of a disc's convolution with a Gaussian; less than half the blur.
    placed.radius[k] = r + shape.blur_px * shape.blur_px / (2 * std::max(r, shape.blur_px));
  }
  placed.roughness_px = std::sqrt(square / placed.seen);
  return placed;
}

void set_deviations(const EdgeShape& shape, int seen, Outline& o) {
  const double radius = 0.5 * o.diameter_px;
  const double independent = std::max(
      kMinIndependent, std::min(double(seen), o.covered * 2 * std::numbers::pi * radius / kIndependent_px));
  const double unseen = (1 - o.covered) * std::max(kUnseenShare * radius, o.roughness_px);
  const double mean_std = std::sqrt(o.roughness_px * o.roughness_px / independent +
                                    kSystematic_px * kSystematic_px + unseen * unseen);
  o.diameter_std_px = 2 * std::sqrt(mean_std * mean_std + shape.shift_std_px * shape.shift_std_px);
  o.x_std = o.y_std = std::sqrt(kCentroidFactor * o.roughness_px * o.roughness_px / independent +
                                kCentroid_px * kCentroid_px + unseen * unseen);
}

// @param reach of the rays: 1 for edges that spread by up to kReachedBlur_px
Outline outline_with(const Scene& scene, const Silhouette& s, const Bulge& bulge, double reach) {
  Outline o;
  const auto u = ray_directions();
  const Point c{bulge.x, bulge.y};
  const PerRay<double> border = silhouette_radii(s, c);
  PerRay<bool> use{};
  use.fill(true);
  const Conic coarse = fit_conic(border, use);
  if (!coarse.valid) return o;
  const double tolerance = kCoarseShare * bulge.radius_px + kCoarseCells * s.scale + kCoarse_px;
  PerRay<Ray> rays;
  for (int k = 0; k < kRays; ++k) {
    const double e = coarse.radius(u[k]);
    use[k] = std::abs(border[k] - e) < tolerance;
    rays[k] = sample_ray(scene, c, u[k], use[k] ? border[k] : e, s.scale, reach);
  }
  HalfwayEdge halfway = find_halfway_edge(rays, use, coarse, tolerance, 2 * bulge.radius_px);
  const Conic fine = fit_conic(halfway.radius, halfway.use);
  if (!fine.valid || halfway.rim.empty()) return o;
  const EdgeShape shape = measure_edge_shape(scene, c, rays, halfway);
  const TrueEdge edge = place_edge(halfway, fine, shape, bulge.radius_px);
  o.opacity = statistics::median(halfway.rim);
  o.blur_px = shape.blur_px;
  if (edge.seen < kMinEdgeRays) return o;
  measure_polygon(edge.radius, c, o);
  o.roughness_px = edge.roughness_px;
  o.covered = double(edge.seen) / kRays;
  set_deviations(shape, edge.seen, o);
  o.found = true;
  return o;
}

}  // namespace

double blurred_std_px(double blur_px, double diameter_px) {
  double reach = 1.0;
  // A blurred droplet's edge lies up to half the blur outside of its silhouette, which sets the rays' reach.
  while (blur_px > kReachedBlur_px * reach && kRayHalf_px * reach < 0.5 * (diameter_px - blur_px))
    reach *= 2.0;
  const double unknown = blur_px > kReachedBlur_px * reach ? kUnreachedBlurs * blur_px : 0.0,
               beyond = std::max(0.0, blur_px - kBlurFree_px), tails = kBlurred_per_px * beyond * beyond;
  return std::sqrt(tails * tails + unknown * unknown);
}

Outline measure_outline(const Scene& scene, const Silhouette& s, const Bulge& bulge) {
  double reach = 1.0;
  Outline o = outline_with(scene, s, bulge, reach);
  while (o.found && o.blur_px > kReachedBlur_px * reach && kRayHalf_px * reach < bulge.radius_px) {
    reach *= 2.0;
    const Outline wider = outline_with(scene, s, bulge, reach);
    if (!wider.found) break;
    o = wider;
  }
  const double blurred = blurred_std_px(o.blur_px, o.diameter_px);
  o.diameter_std_px = std::sqrt(o.diameter_std_px * o.diameter_std_px + blurred * blurred);
  return o;
}

double axis_ratio(const Outline& o, Point u) {
  const double along = o.xx * u.x * u.x + 2 * o.xy * u.x * u.y + o.yy * u.y * u.y;
  const double across = o.xx * u.y * u.y - 2 * o.xy * u.x * u.y + o.yy * u.x * u.x;
  return along > 0 && across > 0 ? std::sqrt(along / across) : 1.0;
}

}  // namespace firn::vision
