// The coverage oracle computes the areas that extrusion lines leave uncovered by brute force: a raster of
// points, each tested for its distance from every edge of the outline and every line nearby, and an exact
// Euclidean distance transform of the uncovered ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/planar.h"
#include "core/slice/paths/layer_paths.h"
#include "tests/core/slice/offset_oracle.h"

namespace firn::slice::oracle {

struct Spot {
  double widest_mm = 0;  ///< diameter of the largest circle of places without a bead
  geometry::Vec at_mm;   ///< its middle
  double gap_mm2 = 0, wanted_mm2 = 0;
};

// Squared distances to the nearest 0 along one row [P. Felzenszwalb, D. Huttenlocher 2012].
inline void transform_row(std::vector<double>& f) {
  const int n = int(f.size());
  std::vector<double> d(f.size()), z(f.size() + 1);
  std::vector<int> v(f.size());
  int k = 0;
  z[0] = -1e300;
  z[1] = 1e300;
  for (int q = 1; q < n; ++q) {
    double s;
    for (;;) {
      const double p = v[std::size_t(k)];
      s = (f[std::size_t(q)] + double(q) * q - f[std::size_t(p)] - p * p) / (2 * (q - p));
      if (s > z[std::size_t(k)]) break;
      --k;
    }
    ++k;
    v[std::size_t(k)] = q;
    z[std::size_t(k)] = s;
    z[std::size_t(k) + 1] = 1e300;
  }
  k = 0;
  for (int q = 0; q < n; ++q) {
    while (z[std::size_t(k) + 1] < q) ++k;
    const double off = q - v[std::size_t(k)];
    d[std::size_t(q)] = off * off + f[std::size_t(v[std::size_t(k)])];
  }
  f = d;
}

/// @param inset_mm of the wanted area from the outline; < 0: beyond it
/// @param lines, widths centre lines and widths of the beads that are to cover it, units
inline Spot widest_spot(const geometry::Region& region, double inset_mm,
                        const std::vector<std::vector<geometry::Vec>>& lines,
                        const std::vector<double>& widths, double pitch_mm) {
  Spot spot;
  if (region.empty()) return spot;
  const double pitch = pitch_mm * geometry::kUnitsPerMm, inset = inset_mm * geometry::kUnitsPerMm;
  geometry::Vec low = to_vec(region.points[0]), high = low;
  for (const geometry::Point p : region.points) {
    low = {std::min(low.x, double(p.x)), std::min(low.y, double(p.y))};
    high = {std::max(high.x, double(p.x)), std::max(high.y, double(p.y))};
  }
  const double margin = std::max(0.0, -inset) + 2 * pitch;
  low = low - geometry::Vec{margin, margin};
  high = high + geometry::Vec{margin, margin};
  const int nx = int((high.x - low.x) / pitch) + 1, ny = int((high.y - low.y) / pitch) + 1;
  const auto index = [&](int x, int y) { return std::size_t(y) * std::size_t(nx) + std::size_t(x); };
  std::vector<std::uint8_t> wanted(std::size_t(nx) * std::size_t(ny), 0), covered(wanted.size(), 0),
      near(wanted.size(), 0);
  const auto each_within = [&](geometry::Vec a, geometry::Vec b, double reach, auto&& f) {
    const int x0 = std::max(0, int((std::min(a.x, b.x) - reach - low.x) / pitch)),
              y0 = std::max(0, int((std::min(a.y, b.y) - reach - low.y) / pitch));
    const int x1 = std::min(nx - 1, int((std::max(a.x, b.x) + reach - low.x) / pitch) + 1);
    const int y1 = std::min(ny - 1, int((std::max(a.y, b.y) + reach - low.y) / pitch) + 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        if (distance(low + geometry::Vec{x * pitch, y * pitch}, {a, b}) <= reach) f(index(x, y));
  };
  const std::vector<Segment> outline = segments_of(region);
  for (int y = 0; y < ny; ++y) {
    std::vector<double> cuts;
    const double at = low.y + y * pitch + 0.37;
    for (const Segment& s : outline)
      if ((s.a.y <= at) != (s.b.y <= at))
        cuts.push_back(s.a.x + (at - s.a.y) / (s.b.y - s.a.y) * (s.b.x - s.a.x));
    std::sort(cuts.begin(), cuts.end());
    std::size_t passed = 0;
    for (int x = 0; x < nx; ++x) {
      while (passed < cuts.size() && cuts[passed] <= low.x + x * pitch) ++passed;
      wanted[index(x, y)] = passed % 2;
    }
  }
  for (const Segment& s : outline)
    if (inset != 0) each_within(s.a, s.b, std::abs(inset), [&](std::size_t i) { near[i] = 1; });
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (near[i]) wanted[i] = inset < 0;
  for (std::size_t l = 0; l < lines.size(); ++l)
    for (std::size_t p = 1; p < lines[l].size(); ++p)
      each_within(lines[l][p - 1], lines[l][p], 0.5 * widths[l], [&](std::size_t i) { covered[i] = 1; });
  std::vector<double> square(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const bool gap = wanted[i] && !covered[i];
    square[i] = gap ? 1e12 : 0;
    spot.wanted_mm2 += wanted[i] * pitch_mm * pitch_mm;
    spot.gap_mm2 += gap * pitch_mm * pitch_mm;
  }
  std::vector<double> row;
  for (int y = 0; y < ny; ++y) {
    row.assign(square.begin() + std::ptrdiff_t(index(0, y)),
               square.begin() + std::ptrdiff_t(index(0, y)) + nx);
    transform_row(row);
    std::copy(row.begin(), row.end(), square.begin() + std::ptrdiff_t(index(0, y)));
  }
  for (int x = 0; x < nx; ++x) {
    row.resize(std::size_t(ny));
    for (int y = 0; y < ny; ++y) row[std::size_t(y)] = square[index(x, y)];
    transform_row(row);
    for (int y = 0; y < ny; ++y)
      if (row[std::size_t(y)] > spot.widest_mm) {
        spot.widest_mm = row[std::size_t(y)];
        spot.at_mm = geometry::kMmPerUnit * (low + geometry::Vec{x * pitch, y * pitch});
      }
  }
  // To the first place that has a bead: half a pitch too far on average.
  spot.widest_mm = 2 * std::sqrt(spot.widest_mm) * pitch_mm;
  return spot;
}

/// Of one material of a planned layer; hooks stand in the scaffold's place.
inline Spot widest_spot(const geometry::Region& region, double inset_mm, const LayerPaths& paths,
                        std::uint8_t material, double pitch_mm) {
  std::vector<std::vector<geometry::Vec>> lines;
  std::vector<double> widths;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    const PathInfo& info = paths.info[i];
    if (info.kind == PathKind::kMeasurement || (info.kind == PathKind::kHook ? 1 : info.material) != material)
      continue;
    std::vector<geometry::Vec> line;
    for (const geometry::Point p : paths.lines[i]) line.push_back(to_vec(p));
    if (info.closed) line.push_back(line[0]);
    lines.push_back(line);
    widths.push_back(info.width);
  }
  return widest_spot(region, inset_mm, lines, widths, pitch_mm);
}

}  // namespace firn::slice::oracle
