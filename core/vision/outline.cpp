#include "core/vision/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/statistics/median.h"
#include "core/vision/least_squares.h"
#include "core/vision/raster.h"
#include "core/vision/rim.h"

namespace firn::vision {
namespace {

constexpr int kRays = 128;
constexpr double kStep = 0.5;       // along a ray [px]
constexpr double kWidest_px = 2.8;  // edge spread that rays of this step reach over
constexpr double kInside_px = 9.0;  // a ray's length on either side of the edge
constexpr double kSystematic_px =
    0.03;  // pixel grid, interpolation, compression: what averaging does not remove
// Out of focus the plateaus and the ground of the rays lie in the tails of the blur; measured on drawn discs
// of 16 to 120 px.
constexpr double kBlurFree_px = 1.5, kBlurred_per_px = 0.025;  // std of a diameter: (blur - free)^2 times it
constexpr double kCentroid_px = 0.008;                         // of it, what opposite sides do not share

constexpr double kClipped = 0.5;  // of the blur: how far a saturated ground moves an edge that is not fitted

// Evenly spaced directions by bisection: square roots alone give the same bytes on every machine.
std::array<Point, kRays> directions() {
  std::array<Point, kRays> d{};
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

// Iteratively reweighted: a point counts by its distance from the ellipse before, none beyond 3 spreads.
Conic fit_conic(const std::array<double, kRays>& r, const std::array<bool, kRays>& use) {
  const auto u = directions();
  Conic conic;
  std::vector<double> radii, off;
  for (int k = 0; k < kRays; ++k)
    if (use[k]) radii.push_back(r[k]);
  if (radii.size() < 24) return conic;
  const double scale = statistics::median(radii);
  std::array<double, kRays> weight{};
  for (int k = 0; k < kRays; ++k) weight[k] = use[k] && r[k] < 1.35 * scale && r[k] > 0.5 * scale ? 1.0 : 0.0;
  for (int round = 0; round < 8; ++round) {
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
    std::array<double, kRays> distance{};
    for (int k = 0; k < kRays; ++k) {
      const double e = next.radius(u[k]);
      if (e <= 0.0 || e > 3 * scale) return conic;
      distance[k] = std::abs(r[k] - e);
      if (use[k]) off.push_back(distance[k]);
    }
    conic = next;
    const double limit = std::max(3.0 * statistics::kMadToStd * statistics::median(off), 0.01 * scale + 0.05);
    for (int k = 0; k < kRays; ++k) {
      const double q = distance[k] / limit;
      weight[k] = use[k] && q < 1 ? (1 - q * q) * (1 - q * q) : 0.0;
    }
  }
  return conic;
}

struct Ray {
  double start = 0.0, step = kStep;
  std::vector<double> opacity;
  double inside = 0.0, outside = 0.0;
  std::size_t darkest = 0;
  double at(std::size_t i) const { return start + step * double(i); }
};

// Opacity from inside of the rim to 10 px beyond the silhouette, or `reach` times as far in such steps.
Ray sample(const Scene& scene, Point c, Point u, double r, double scale, double reach) {
  Ray ray;
  const double in = std::min(reach * kInside_px + scale, 0.7 * r), out = reach * kInside_px + scale;
  ray.start = r - in;
  ray.step = reach * kStep;
  for (double d = -in; d <= out; d += ray.step)
    ray.opacity.push_back(scene.opacity(c.x + u.x * (r + d), c.y + u.y * (r + d)));
  const std::size_t n = ray.opacity.size(), edge = std::min(n - 1, std::size_t((in + scale) / ray.step) + 2);
  for (std::size_t i = 0; i <= edge; ++i) {
    double s = 0.0;
    int m = 0;
    for (std::size_t j = i >= 2 ? i - 2 : 0; j <= std::min(n - 1, i + 2); ++j, ++m) s += ray.opacity[j];
    if (s / m > ray.inside) {
      ray.inside = s / m;
      ray.darkest = i;
    }
  }
  double s = 0.0;
  for (std::size_t i = n - 6; i < n; ++i) s += ray.opacity[i] / 6;
  ray.outside = s < 0.2 ? s : 0.0;
  return ray;
}

// The halfway point outwards from the darkest sample; false where the ray does not become bright.
bool crossing(const Ray& ray, double inside, double& r) {
  const double half = 0.5 * (inside + ray.outside);
  for (std::size_t i = ray.darkest; i + 2 < ray.opacity.size(); ++i) {
    if (ray.opacity[i] < half || ray.opacity[i + 1] >= half || ray.opacity[i + 2] >= half) continue;
    r = ray.at(i) + ray.step * (ray.opacity[i] - half) / (ray.opacity[i] - ray.opacity[i + 1]);
    return true;
  }
  return false;
}

// Edge spread: the integral of a Gaussian edge from its halfway point outwards is s / sqrt(2 pi) of its
// height. The rays are averaged before it is taken, since it would add up their noise.
double edge_blur(const std::array<Ray, kRays>& rays, const std::array<double, kRays>& r,
                 const std::array<bool, kRays>& use) {
  constexpr int kSamples = 20;
  const double pitch = 0.5 * rays[0].step;
  std::array<double, kSamples> mean{};
  int n = 0;
  for (int k = 0; k < kRays; ++k) {
    if (!use[k]) continue;
    const Ray& ray = rays[k];
    const double height = ray.inside - ray.outside, last = ray.at(ray.opacity.size() - 2);
    if (height <= 0 || r[k] + kSamples * pitch > last) continue;
    ++n;
    for (int i = 0; i < kSamples; ++i) {
      const double at = (r[k] + (i + 0.5) * pitch - ray.start) / ray.step;
      const std::size_t j = std::size_t(at);
      mean[i] +=
          ((1 - (at - double(j))) * ray.opacity[j] + (at - double(j)) * ray.opacity[j + 1] - ray.outside) /
          height;
    }
  }
  if (n == 0) return 0.0;
  double sum = 0.0;
  for (const double m : mean) sum += std::max(0.0, m / n) * pitch;
  return sum * std::sqrt(2 * std::numbers::pi);
}

/// The opacity across the rim, averaged over the rays at equal distances from their halfway points.
struct MeanProfile {
  std::vector<double> opacity;  ///< empty: too few rays
  double first_px = 0.0, pitch_px = 0.0;
};

MeanProfile mean_profile(const std::array<Ray, kRays>& rays, const std::array<double, kRays>& r,
                         const std::array<bool, kRays>& use) {
  constexpr int kInwards = 18, kOutwards = 12;
  const double pitch = rays[0].step;
  std::array<double, kInwards + kOutwards + 1> mean{};
  std::array<int, kInwards + kOutwards + 1> n{};
  for (int k = 0; k < kRays; ++k) {
    if (!use[k]) continue;
    const Ray& ray = rays[k];
    for (int i = -kInwards; i <= kOutwards; ++i) {
      const double at = (r[k] + i * pitch - ray.start) / ray.step;
      if (at < 0.0 || at + 1.0 >= double(ray.opacity.size())) continue;
      const std::size_t j = std::size_t(at);
      mean[std::size_t(i + kInwards)] +=
          (1 - (at - double(j))) * ray.opacity[j] + (at - double(j)) * ray.opacity[j + 1] - ray.outside;
      ++n[std::size_t(i + kInwards)];
    }
  }
  const int most = *std::ranges::max_element(n);
  int first = 0, last = kInwards + kOutwards;
  while (first < last && 2 * n[std::size_t(first)] < most) ++first;
  while (last > first && 2 * n[std::size_t(last)] < most) --last;
  MeanProfile profile{{}, (first - kInwards) * pitch, pitch};
  if (most < kRays / 4) return profile;
  for (int i = first; i <= last; ++i) profile.opacity.push_back(mean[std::size_t(i)] / n[std::size_t(i)]);
  return profile;
}

// The true edge of a ring, not found where the profile is none of a ring.
RimFit thin_rim(const MeanProfile& p, double blur_px) {
  return p.opacity.empty() ? RimFit{} : fit_rim(p.opacity, p.first_px, p.pitch_px, blur_px);
}

// Rays whose ground the sensor shows as white.
std::array<bool, kRays> clipped_rays(const Scene& scene, Point c, const std::array<Ray, kRays>& rays,
                                     const std::array<bool, kRays>& use) {
  constexpr std::size_t kGround = 6;
  const auto u = directions();
  const Frame& f = scene.frame();
  std::array<bool, kRays> clipped{};
  if (scene.light().inverted) return clipped;
  for (int k = 0; k < kRays; ++k) {
    int white = 0;
    for (std::size_t i = rays[k].opacity.size() - kGround; i < rays[k].opacity.size(); ++i) {
      const int x = std::clamp(int(c.x + u[k].x * rays[k].at(i) + 0.5), 0, f.width - 1),
                y = std::clamp(int(c.y + u[k].y * rays[k].at(i) + 0.5), 0, f.height - 1);
      white += f.at(x, y) >= f.white;
    }
    clipped[k] = use[k] && 4 * white >= 3 * int(kGround);
  }
  return clipped;
}

void measure_polygon(const std::array<double, kRays>& r, Point centre, Outline& o) {
  const auto u = directions();
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

// @param reach of the rays: 1 for edges that spread by up to kWidest_px
Outline outline_with(const Scene& scene, const Silhouette& s, const Bulge& bulge, double reach) {
  Outline o;
  const auto u = directions();
  const Point c{bulge.x, bulge.y};
  std::array<double, kRays> r{};
  std::array<bool, kRays> use{};
  use.fill(true);
  for (int k = 0; k < kRays; ++k) {
    const double step = 0.5 * s.scale;
    double d = 0.0;
    while (s.at(int(std::floor((c.x + u[k].x * d + 0.5 - s.x0) / s.scale)),
                int(std::floor((c.y + u[k].y * d + 0.5 - s.y0) / s.scale))))
      d += step;
    r[k] = std::max(1.0, d - 0.5 * step);
  }
  const Conic coarse = fit_conic(r, use);
  if (!coarse.valid) return o;
  std::array<Ray, kRays> rays;
  const double slack = 0.12 * bulge.radius_px + 1.5 * s.scale + 1.0;
  for (int k = 0; k < kRays; ++k) {
    const double e = coarse.radius(u[k]);
    use[k] = std::abs(r[k] - e) < slack;
    rays[k] = sample(scene, c, u[k], use[k] ? r[k] : e, s.scale, reach);
  }
  std::vector<double> near;
  std::array<double, kRays> edge{};
  std::vector<double> inside;
  for (const Ray& ray : rays) inside.push_back(ray.inside);
  const double rim = statistics::median(inside);
  inside.clear();
  // The rim of a small blurred droplet does not reach its plateau. Liquid refracts all light away there, as
  // opaque objects do: their level is taken instead, the more the smaller the droplet, unless the rim is much
  // paler.
  const double small = std::clamp((24.0 - bulge.radius_px * 2) / 10.0, 0.0, 1.0);
  const double lift = rim > 0.75 && rim < 1.0 ? small * (1.0 - rim) : 0.0;
  for (int k = 0; k < kRays; ++k) {
    near.clear();
    for (int d = -4; d <= 4; ++d) near.push_back(rays[std::size_t((k + d + kRays) % kRays)].inside);
    const double q = statistics::median(near) + lift;
    if (use[k]) inside.push_back(q);
    if (!use[k]) continue;
    use[k] = crossing(rays[k], q, edge[k]) && std::abs(edge[k] - coarse.radius(u[k])) < slack;
  }
  const Conic fine = fit_conic(edge, use);
  if (!fine.valid || inside.empty()) return o;
  o.opacity = statistics::median(inside);
  o.blur_px = edge_blur(rays, edge, use);
  const RimFit rim_fit = thin_rim(mean_profile(rays, edge, use), o.blur_px);
  if (rim_fit.found) o.blur_px = rim_fit.blur_px;
  const std::array<bool, kRays> clipped = clipped_rays(scene, c, rays, use);
  ClippedEdge cut;
  const bool ground_clipped = std::ranges::count(clipped, true) >= kRays / 4;
  if (ground_clipped && !rim_fit.found) {
    const MeanProfile p = mean_profile(rays, edge, clipped);
    if (!p.opacity.empty()) cut = fit_clipped_edge(p.opacity, p.first_px, p.pitch_px, o.blur_px);
  }
  if (cut.found) o.blur_px = cut.blur_px;

  std::vector<double> off;
  for (int k = 0; k < kRays; ++k)
    if (use[k]) off.push_back(std::abs(edge[k] - fine.radius(u[k])));
  const double spread = statistics::kMadToStd * statistics::median(off);
  const double limit = std::max({4 * spread, 0.03 * bulge.radius_px, 0.3});
  double square = 0.0;
  int seen = 0;
  for (int k = 0; k < kRays; ++k) {
    const double e = fine.radius(u[k]);
    if (use[k] && std::abs(edge[k] - e) < limit) {
      square += (edge[k] - e) * (edge[k] - e);
      ++seen;
    } else {
      edge[k] = e;
    }
    if (rim_fit.found) edge[k] += rim_fit.edge_px;
    if (cut.found) edge[k] += cut.edge_px;
    edge[k] += o.blur_px * o.blur_px / (2 * std::max(edge[k], o.blur_px));  // less than half the blur
  }
  if (seen < kRays / 4) return o;
  measure_polygon(edge, c, o);
  o.roughness_px = std::sqrt(square / seen);
  o.covered = double(seen) / kRays;
  const double radius = 0.5 * o.diameter_px;
  const double independent =
      std::max(4.0, std::min(double(seen), o.covered * 2 * std::numbers::pi * radius / 1.5));
  const double unseen = (1 - o.covered) * std::max(0.02 * radius, o.roughness_px);
  const double mean_std = std::sqrt(o.roughness_px * o.roughness_px / independent +
                                    kSystematic_px * kSystematic_px + unseen * unseen);
  const double clipped_std = !ground_clipped ? 0.0 : cut.found ? cut.edge_std_px : kClipped * o.blur_px;
  o.diameter_std_px = 2 * std::sqrt(mean_std * mean_std + clipped_std * clipped_std);
  o.x_std = o.y_std = std::sqrt(1.2 * o.roughness_px * o.roughness_px / independent +
                                kCentroid_px * kCentroid_px + unseen * unseen);
  o.found = true;
  return o;
}

}  // namespace

double blurred_std_px(double blur_px, double diameter_px) {
  double reach = 1.0;
  // A blurred droplet's edge lies up to half the blur outside of its silhouette, which sets the rays' reach.
  while (blur_px > kWidest_px * reach && kInside_px * reach < 0.5 * (diameter_px - blur_px)) reach *= 2.0;
  const double unknown = blur_px > kWidest_px * reach ? 0.5 * blur_px : 0.0,
               beyond = std::max(0.0, blur_px - kBlurFree_px), tails = kBlurred_per_px * beyond * beyond;
  return std::sqrt(tails * tails + unknown * unknown);
}

Outline measure_outline(const Scene& scene, const Silhouette& s, const Bulge& bulge) {
  double reach = 1.0;
  Outline o = outline_with(scene, s, bulge, reach);
  while (o.found && o.blur_px > kWidest_px * reach && kInside_px * reach < bulge.radius_px) {
    reach *= 2.0;
    const Outline wider = outline_with(scene, s, bulge, reach);
    if (!wider.found) break;
    o = wider;
  }
  const double blurred = blurred_std_px(o.blur_px, o.diameter_px);
  o.diameter_std_px = std::sqrt(o.diameter_std_px * o.diameter_std_px + blurred * blurred);
  return o;
}

Outline integrate_spot(const Scene& scene, const Component& c, double opaque) {
  Outline o;
  constexpr int kMargin = 3;
  const int x0 = std::max(0, c.x0 - kMargin), y0 = std::max(0, c.y0 - kMargin);
  const int x1 = std::min(scene.frame().width - 1, c.x1 + kMargin),
            y1 = std::min(scene.frame().height - 1, c.y1 + kMargin);
  const int w = x1 - x0 + 1, h = y1 - y0 + 1;
  CellMask spot(w, h);
  for (const Run& run : c.runs)
    std::fill_n(spot.cells.begin() + std::ptrdiff_t(spot.index(run.x0 - x0, run.y - y0)), run.x1 - run.x0 + 1,
                std::uint8_t(1));
  const std::vector<std::uint8_t> near = dilated(spot).cells;
  double sum = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, most = 0;
  long n = 0;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      if (!near[std::size_t(y - y0) * std::size_t(w) + std::size_t(x - x0)]) continue;
      const double t = scene.opacity(x, y);
      ++n;
      sum += t;
      sx += t * x;
      sy += t * y;
      most = std::max(most, t);
    }
  if (sum <= 0 || opaque <= 0) return o;
  o.x = sx / sum;
  o.y = sy / sum;
  // Glare beside the spot weighs less than nothing.
  if (o.x < x0 || o.x > x1 || o.y < y0 || o.y > y1) return o;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x)
      if (near[std::size_t(y - y0) * std::size_t(w) + std::size_t(x - x0)]) {
        const double t = scene.opacity(x, y), dx = x - o.x, dy = y - o.y;
        sxx += t * dx * dx;
        sxy += t * dx * dy;
        syy += t * dy * dy;
      }
  o.xx = std::max(0.0, sxx / sum);
  o.xy = sxy / sum;
  o.yy = std::max(0.0, syy / sum);
  const double area = sum / opaque, noise = scene.noise() / opaque;
  o.diameter_px = 2 * std::sqrt(area / std::numbers::pi);
  // dA = pi d / 2 dd; the sum's noise, and 3 % of the area for `opaque` and the ground.
  const double area_std = std::sqrt(double(n) * noise * noise + 0.0009 * area * area);
  o.diameter_std_px = std::sqrt(4 * area_std * area_std /
                                    (std::numbers::pi * std::numbers::pi * o.diameter_px * o.diameter_px) +
                                4 * kSystematic_px * kSystematic_px);
  const double spread = std::max(o.xx, o.yy) + 1.0;
  o.x_std = o.y_std =
      std::sqrt(double(n) * noise * noise * spread / (area * area) + kSystematic_px * kSystematic_px);
  o.opacity = most;
  o.covered = 1.0;
  o.found = true;
  return o;
}

double axis_ratio(const Outline& o, Point u) {
  const double along = o.xx * u.x * u.x + 2 * o.xy * u.x * u.y + o.yy * u.y * u.y;
  const double across = o.xx * u.y * u.y - 2 * o.xy * u.x * u.y + o.yy * u.x * u.x;
  return along > 0 && across > 0 ? std::sqrt(along / across) : 1.0;
}

}  // namespace firn::vision
