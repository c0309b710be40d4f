#include "core/slice/coverage/footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/options/range.h"

namespace firn::slice {
namespace {

struct At {
  double x, y;
};

At in_mm(const geometry::Point& p) { return {p.x * geometry::kMmPerUnit, p.y * geometry::kMmPerUnit}; }

template <class Visit>
void each_segment(const LayerPaths& layer, const Visit& visit) {
  for (std::size_t n = 0; n < layer.lines.size(); ++n) {
    const PathInfo& info = layer.info[n];
    if (info.kind == PathKind::kMeasurement) continue;
    const auto line = layer.lines[n];
    const std::size_t segments = line.size() < 2 ? line.size() : line.size() - (info.closed ? 0 : 1);
    for (std::size_t k = 0; k < segments; ++k)
      visit(in_mm(line[k]), in_mm(line[(k + 1) % line.size()]), info);
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
  if (!(pitch_mm > 0.0 && pitch_mm <= 100.0))
    throw std::invalid_argument("a grid's pitch of " + shortest_text(pitch_mm) +
                                " mm is not within (0, 100]");
  double x0 = std::numeric_limits<double>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  each_segment(layer, [&](const At& a, const At& b, const PathInfo& info) {
    const double r = 0.5 * info.width * geometry::kMmPerUnit;
    x0 = std::min({x0, a.x - r, b.x - r});
    x1 = std::max({x1, a.x + r, b.x + r});
    y0 = std::min({y0, a.y - r, b.y - r});
    y1 = std::max({y1, a.y + r, b.y + r});
  });
  if (x1 < x0) throw std::invalid_argument("layer " + std::to_string(layer.layer) + " deposits nothing");
  const double i0 = std::floor(x0 / pitch_mm), i1 = std::ceil(x1 / pitch_mm), j0 = std::floor(y0 / pitch_mm),
               j1 = std::ceil(y1 / pitch_mm);
  if (i1 - i0 + 2.0 > kMaxGridSide || j1 - j0 + 2.0 > kMaxGridSide)
    throw std::invalid_argument("layer " + std::to_string(layer.layer) + " needs more than " +
                                std::to_string(kMaxGridSide) + " cells a side");
  const auto even = [](double cells) { return (int(cells) + 2) / 2 * 2; };
  return {even(i1 - i0), even(j1 - j0), pitch_mm, pitch_mm, i0 * pitch_mm, j0 * pitch_mm};
}

Grid<std::uint8_t> footprint_materials(const LayerPaths& layer, const GridSpec& g) {
  check(g);
  Grid<std::uint8_t> material(g);
  std::vector<double> nearest(g.size(), std::numeric_limits<double>::max());
  each_segment(layer, [&](const At& a, const At& b, const PathInfo& info) {
    const double r = 0.5 * info.width * geometry::kMmPerUnit, r2 = r * r * (1.0 + 1e-12);
    const auto cells = [&](double low, double high, double origin, double pitch, int n) {
      return std::pair(std::max(0, int(std::ceil((low - r - origin) / pitch))),
                       std::min(n - 1, int(std::floor((high + r - origin) / pitch))));
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

namespace {

// Returns the bare cells that are connected to `from` by steps to four neighbours, and marks them in `seen`.
std::vector<std::size_t> bare_about(const Mask& mask, std::size_t from, std::vector<std::uint8_t>& seen) {
  const GridSpec& g = mask.spec;
  std::vector<std::size_t> cells{from};
  seen[from] = 1;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const int i = int(cells[n]) % g.nx, j = int(cells[n]) / g.nx;
    for (const auto& [x, y] : {std::pair{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}}) {
      if (!g.contains(x, y) || mask.at(x, y) || seen[g.index(x, y)]) continue;
      seen[g.index(x, y)] = 1;
      cells.push_back(g.index(x, y));
    }
  }
  return cells;
}

}  // namespace

Mask without_narrow_holes(const Mask& mask, double widest_mm) {
  const GridSpec& g = mask.spec;
  const int wide = int(widest_mm / g.pitch_x_mm + 1e-9) + 1, high = int(widest_mm / g.pitch_y_mm + 1e-9) + 1;
  const auto stays = [&](std::size_t cell) {  // at the border of the grid, or the low corner of a bare square
    const int i = int(cell) % g.nx, j = int(cell) / g.nx;
    if (i == 0 || j == 0 || i + 1 == g.nx || j + 1 == g.ny) return true;
    for (int y = j; y < j + high; ++y)
      for (int x = i; x < i + wide; ++x)
        if (!g.contains(x, y) || mask.at(x, y)) return false;
    return true;
  };
  Mask out = mask;
  std::vector<std::uint8_t> seen(mask.size());
  for (std::size_t c = 0; c < mask.size(); ++c) {
    if (mask.cells[c] || seen[c]) continue;
    const std::vector<std::size_t> hole = bare_about(mask, c, seen);
    if (std::none_of(hole.begin(), hole.end(), stays))
      for (const std::size_t h : hole) out.cells[h] = 1;
  }
  return out;
}

namespace {

constexpr double kSample_mm = 0.25;

// Computes the area of lines on the square of each cell.
HeightMap laid_area(const LayerPaths& layer, const GridSpec& g) {
  HeightMap area(g, 0.0);
  each_segment(layer, [&](const At& a, const At& b, const PathInfo& info) {
    const double dx = b.x - a.x, dy = b.y - a.y, length = std::sqrt(dx * dx + dy * dy),
                 width = info.width * geometry::kMmPerUnit;
    if (!(length > 0.0 && width > 0.0)) return;
    const int along = std::max(1, int(std::ceil(length / kSample_mm))),
              across = std::max(1, int(std::ceil(width / kSample_mm)));
    const double share = length * width / (double(along) * double(across));
    for (int n = 0; n < along; ++n)
      for (int m = 0; m < across; ++m) {
        const double s = (n + 0.5) / along, t = ((m + 0.5) / across - 0.5) * width / length;
        const double x = a.x + s * dx - t * dy, y = a.y + s * dy + t * dx;
        const int i = int(std::floor((x - g.origin_x_mm) / g.pitch_x_mm + 0.5)),
                  j = int(std::floor((y - g.origin_y_mm) / g.pitch_y_mm + 0.5));
        if (g.contains(i, j)) area.at(i, j) += share;
      }
  });
  return area;
}

}  // namespace

HeightMap extrusion_coverage(const LayerPaths& layer, const GridSpec& g, double window_mm,
                             double widest_hole_mm) {
  const Mask needs = without_narrow_holes(footprint_mask(footprint_materials(layer, g)), widest_hole_mm);
  const HeightMap area = laid_area(layer, g);
  const int rx = int(0.5 * window_mm / g.pitch_x_mm + 1e-9), ry = int(0.5 * window_mm / g.pitch_y_mm + 1e-9);
  HeightMap out(g, 1.0);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      double laid = 0.0, needed = 0.0;
      for (int y = std::max(j - ry, 0); y <= std::min(j + ry, g.ny - 1); ++y)
        for (int x = std::max(i - rx, 0); x <= std::min(i + rx, g.nx - 1); ++x) {
          laid += area.at(x, y);
          needed += needs.at(x, y);
        }
      if (needed > 0.0 && needs.at(i, j)) out.at(i, j) = laid / (needed * g.pitch_x_mm * g.pitch_y_mm);
    }
  return out;
}

}  // namespace firn::slice
