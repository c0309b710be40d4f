#include "core/slice/footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace firn::slice {
namespace {

struct At {
  double x, y;
};

At in_mm(const Point& p) { return {p.x * kMmPerUnit, p.y * kMmPerUnit}; }

template <class Visit>
void each_segment(const LayerPaths& layer, const Visit& visit) {
  for (std::size_t n = 0; n < layer.lines.size(); ++n) {
    const PathInfo& info = layer.info[n];
    if (info.kind == PathKind::kMeasurement) continue;
    const auto line = layer.lines[n];
    const std::size_t segments = line.size() < 2 ? line.size() : line.size() - (info.closed ? 0 : 1);
    for (std::size_t k = 0; k < segments; ++k) visit(in_mm(line[k]), in_mm(line[(k + 1) % line.size()]), info);
  }
}

double distance2(const At& a, const At& b, double x, double y) {
  const double dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy;
  const double t = length2 > 0.0 ? std::clamp(((x - a.x) * dx + (y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
  const double ex = x - a.x - t * dx, ey = y - a.y - t * dy;
  return ex * ex + ey * ey;
}

}  // namespace

GridSpec footprint_grid(const LayerPaths& layer, double pitch_mm) {
  if (!(pitch_mm > 0.0 && pitch_mm <= 100.0)) throw std::invalid_argument("a grid's pitch of " + std::to_string(pitch_mm) + " mm is not within (0, 100]");
  double x0 = std::numeric_limits<double>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  each_segment(layer, [&](const At& a, const At& b, const PathInfo& info) {
    const double r = 0.5 * info.width * kMmPerUnit;
    x0 = std::min({x0, a.x - r, b.x - r}), x1 = std::max({x1, a.x + r, b.x + r});
    y0 = std::min({y0, a.y - r, b.y - r}), y1 = std::max({y1, a.y + r, b.y + r});
  });
  if (x1 < x0) throw std::invalid_argument("layer " + std::to_string(layer.layer) + " deposits nothing");
  const double i0 = std::floor(x0 / pitch_mm), i1 = std::ceil(x1 / pitch_mm), j0 = std::floor(y0 / pitch_mm), j1 = std::ceil(y1 / pitch_mm);
  if (i1 - i0 + 2.0 > kMaxGridSide || j1 - j0 + 2.0 > kMaxGridSide)
    throw std::invalid_argument("layer " + std::to_string(layer.layer) + " needs more than " + std::to_string(kMaxGridSide) + " cells a side");
  const auto even = [](double cells) { return (int(cells) + 2) / 2 * 2; };
  return {even(i1 - i0), even(j1 - j0), pitch_mm, pitch_mm, i0 * pitch_mm, j0 * pitch_mm};
}

Grid<std::uint8_t> footprint_materials(const LayerPaths& layer, const GridSpec& g) {
  check(g);
  Grid<std::uint8_t> material(g);
  std::vector<double> nearest(g.size(), std::numeric_limits<double>::max());
  each_segment(layer, [&](const At& a, const At& b, const PathInfo& info) {
    const double r = 0.5 * info.width * kMmPerUnit, r2 = r * r * (1.0 + 1e-12);
    const auto cells = [&](double low, double high, double origin, double pitch, int n) {
      return std::pair(std::max(0, int(std::ceil((low - r - origin) / pitch))), std::min(n - 1, int(std::floor((high + r - origin) / pitch))));
    };
    const auto [i0, i1] = cells(std::min(a.x, b.x), std::max(a.x, b.x), g.origin_x_mm, g.pitch_x_mm, g.nx);
    const auto [j0, j1] = cells(std::min(a.y, b.y), std::max(a.y, b.y), g.origin_y_mm, g.pitch_y_mm, g.ny);
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) {
        const double d2 = distance2(a, b, g.x_mm(i), g.y_mm(j));
        double& best = nearest[g.index(i, j)];
        if (d2 > r2 || d2 >= best) continue;
        best = d2;
        material.at(i, j) = std::uint8_t(info.material + 1);
      }
  });
  return material;
}

Mask footprint_mask(const Grid<std::uint8_t>& materials) {
  Mask m(materials.spec);
  for (std::size_t c = 0; c < m.size(); ++c) m.cells[c] = materials.cells[c] != 0;
  return m;
}

}  // namespace firn::slice
