// Prints the error of a printed surface by zone, for the benches of the ice lab.
#pragma once

#include <cmath>
#include <cstdio>

#include "core/control/surface/disturbance_observer_surface.h"
#include "report/run/report_ice_data.h"

namespace firn::ice_zones {

/// Part, and no scaffold near.
inline bool inside_part(const Grid<std::uint8_t>& material, std::size_t cell) {
  const GridSpec& g = material.spec;
  const int i = int(cell) % g.nx, j = int(cell) / g.nx;
  for (int y = j - 2; y <= j + 2; ++y)
    for (int x = i - 2; x <= i + 2; ++x)
      if (!g.contains(x, y) || material.at(x, y) == std::uint8_t(control::CellMaterial::kScaffold))
        return false;
  return true;
}

/// Prints the error of each zone, and the part of the error that is wider than 5 cells.
inline void tell_zones(const HeightMap& truth, const HeightMap& map, const Grid<std::uint8_t>& material,
                       const Mask& judged, double nominal) {
  constexpr const char* kNames[] = {"inside the part", "part's edge", "scaffold", "spots between beads"};
  double cells[4]{}, squares[4]{}, wide[4]{}, off[4]{}, mean[4]{};
  const GridSpec& g = truth.spec;
  for (std::size_t n = 0; n < truth.size(); ++n) {
    if (!judged.cells[n]) continue;
    const int zone = material.cells[n] == 0                                                ? 3
                     : material.cells[n] == std::uint8_t(control::CellMaterial::kScaffold) ? 2
                     : inside_part(material, n)                                            ? 0
                                                                                           : 1;
    double sum = 0.0, count = 0.0;
    for (int y = int(n) / g.nx - 2; y <= int(n) / g.nx + 2; ++y)
      for (int x = int(n) % g.nx - 2; x <= int(n) % g.nx + 2; ++x)
        if (g.contains(x, y) && judged.at(x, y)) {
          sum += truth.at(x, y) - nominal;
          count += 1.0;
        }
    const double e = truth.cells[n] - nominal, d = truth.cells[n] - map.cells[n];
    cells[zone] += 1.0;
    mean[zone] += e;
    squares[zone] += e * e;
    off[zone] += d * d;
    wide[zone] += sum / count * sum / count;
  }
  for (int z = 0; z < 4; ++z)
    if (cells[z] > 0.0)
      std::printf(
          "      %-20s %5.0f cells: rms %.4f, wider than 5 cells %.4f, mean %+.4f, map - truth %.4f\n",
          kNames[z], cells[z], std::sqrt(squares[z] / cells[z]), std::sqrt(wide[z] / cells[z]),
          mean[z] / cells[z], std::sqrt(off[z] / cells[z]));
}

/// Prints the same by the law's zones: an error that repeats in a zone can be foreseen.
inline void tell_bands(const HeightMap& truth, const HeightMap& map, const Grid<std::uint8_t>& material,
                       const Mask& judged, double nominal) {
  const Grid<std::int8_t> zone = control::zones(material, 1.0);
  double cells[control::kZones]{}, sum[control::kZones]{}, squares[control::kZones]{}, off[control::kZones]{};
  for (std::size_t n = 0; n < truth.size(); ++n) {
    if (!judged.cells[n] || zone.cells[n] < 0) continue;
    const auto z = std::size_t(zone.cells[n]);
    const double e = truth.cells[n] - nominal;
    cells[z] += 1.0;
    sum[z] += e;
    squares[z] += e * e;
    off[z] += map.cells[n] - truth.cells[n];
  }
  for (int z = 0; z < control::kZones; ++z)
    if (cells[z] > 0.0)
      std::printf("      %s, near %s, band %d: %5.0f cells: rms %.4f, mean %+.4f, map - truth %+.4f\n",
                  z < 2 * control::kZoneBands ? "part" : "scaffold",
                  z / control::kZoneBands % 2 ? "bare" : "the other", z % control::kZoneBands, cells[z],
                  std::sqrt(squares[z] / cells[z]), sum[z] / cells[z], off[z] / cells[z]);
}

/// Slope of an error on the one before it, wide and narrow: above 0 the law answers too little, below 0 too
/// much.
inline void tell_slopes(const HeightMap& error, const HeightMap& before, const Grid<std::uint8_t>& material) {
  if (before.size() == 0) return;
  const HeightMap last = resample(before, error.spec, kNotMeasured), wide = control::square_mean(error, 5.0),
                  last_wide = control::square_mean(last, 5.0);
  double xy[3][2]{}, xx[3][2]{};
  for (std::size_t n = 0; n < error.size(); ++n) {
    if (!std::isfinite(error.cells[n]) || !std::isfinite(last.cells[n]) || !material.cells[n]) continue;
    const int zone = material.cells[n] == std::uint8_t(control::CellMaterial::kScaffold) ? 2
                     : inside_part(material, n)                                          ? 0
                                                                                         : 1;
    const double w = wide.cells[n], lw = last_wide.cells[n], s = error.cells[n] - w, ls = last.cells[n] - lw;
    xy[zone][0] += w * lw;
    xx[zone][0] += lw * lw;
    xy[zone][1] += s * ls;
    xx[zone][1] += ls * ls;
  }
  std::printf(
      "      slope on the error before, wide / narrow: inside %+.2f / %+.2f, edge %+.2f / %+.2f, scaffold "
      "%+.2f / %+.2f\n",
      xy[0][0] / xx[0][0], xy[0][1] / xx[0][1], xy[1][0] / xx[1][0], xy[1][1] / xx[1][1], xy[2][0] / xx[2][0],
      xy[2][1] / xx[2][1]);
}

}  // namespace firn::ice_zones
