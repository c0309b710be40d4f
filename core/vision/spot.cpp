// integrate_spot() of core/vision/outline.h: droplets that are too small for an edge.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/vision/outline.h"
#include "core/vision/raster.h"

namespace firn::vision {
namespace {

constexpr int kSpotMargin_px = 3;  // dilated() reaches as far: 2 spreads of a blur of 1.5 px
constexpr double kAreaVariance =
    0.03 * 0.03;                             // relative: the level of opaque and the ground are known to 3 %
constexpr double kSpotSystematic_px = 0.03;  // pixel grid, interpolation, compression: averaging leaves it

}  // namespace

Outline integrate_spot(const Scene& scene, const Component& c, double opaque) {
  Outline o;
  const int x0 = std::max(0, c.x0 - kSpotMargin_px), y0 = std::max(0, c.y0 - kSpotMargin_px);
  const int x1 = std::min(scene.frame().width - 1, c.x1 + kSpotMargin_px),
            y1 = std::min(scene.frame().height - 1, c.y1 + kSpotMargin_px);
  const int w = x1 - x0 + 1, h = y1 - y0 + 1;
  CellMask spot(w, h);
  for (const Run& run : c.runs)
    std::fill_n(spot.cells.begin() + std::ptrdiff_t(spot.index(run.x0 - x0, run.y - y0)), run.x1 - run.x0 + 1,
                std::uint8_t(1));
  const std::vector<std::uint8_t> near = dilated(spot).cells;
  double sum = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, peak = 0;
  long n = 0;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      if (!near[std::size_t(y - y0) * std::size_t(w) + std::size_t(x - x0)]) continue;
      const double t = scene.opacity(x, y);
      ++n;
      sum += t;
      sx += t * x;
      sy += t * y;
      peak = std::max(peak, t);
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
  // dA = pi d / 2 dd
  const double area_std = std::sqrt(double(n) * noise * noise + kAreaVariance * area * area);
  o.diameter_std_px = std::sqrt(4 * area_std * area_std /
                                    (std::numbers::pi * std::numbers::pi * o.diameter_px * o.diameter_px) +
                                4 * kSpotSystematic_px * kSpotSystematic_px);
  const double spread = std::max(o.xx, o.yy) + 1.0;
  o.x_std = o.y_std =
      std::sqrt(double(n) * noise * noise * spread / (area * area) + kSpotSystematic_px * kSpotSystematic_px);
  o.opacity = peak;
  o.covered = 1.0;
  o.found = true;
  return o;
}

}  // namespace firn::vision
