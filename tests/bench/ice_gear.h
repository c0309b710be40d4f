// Computes the helical gear of 107.6 mm in its ring of scaffold, as paths: for the benches of the ice lab.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/slice/paths/path_plan.h"
#include "core/slice/paths/print_paths.h"

namespace firn::ice_gear {

inline constexpr double kLayer_mm = 0.24;
inline constexpr int kInterval_layers = 5;

inline geometry::Region wheel(double radius_mm, double tooth_mm, int teeth, double turn_rad) {
  std::vector<geometry::Point> ring;
  for (int n = 0; n < 24 * teeth; ++n) {
    const double a = 2.0 * 3.14159265358979 * n / (24 * teeth), phase = std::cos(teeth * (a + turn_rad));
    const double r = radius_mm - 0.5 * tooth_mm + 0.5 * tooth_mm * std::tanh(1.5 * phase);
    ring.push_back({std::int32_t(std::lround(r * std::cos(a) * geometry::kUnitsPerMm)),
                    std::int32_t(std::lround(r * std::sin(a) * geometry::kUnitsPerMm))});
  }
  geometry::Region region;
  region.add(ring);
  return region;
}

inline geometry::Region ring_about(const geometry::Region& inner, double radius_mm) {
  geometry::Region outer = wheel(radius_mm, 0.0, 12, 0.0);
  std::vector<geometry::Point> hole(inner[0].rbegin(), inner[0].rend());
  outer.add(hole);
  return outer;
}

/// Layer `number`; every kInterval_layers-th is measured, on rings `spacing_mm` apart. `size` scales the
/// wheel.
inline slice::LayerPaths layer(int number, double size = 1.0, double spacing_mm = 4.0) {
  slice::LayerRegions r;
  r.layer = number;
  r.z = std::int32_t(std::lround(kLayer_mm * number * geometry::kUnitsPerMm));
  r.height = std::int32_t(std::lround(kLayer_mm * geometry::kUnitsPerMm));
  const geometry::Region part = wheel(53.8 * size, 7.0 * size, 12, 0.004 * number);
  r.by_material = {part, ring_about(part, 59.2 * size)};
  slice::PathOptions o;
  o.scaffold.fill_width_mm = 1.5;
  slice::LayerPaths paths = plan_layer(r, o);
  if (number % kInterval_layers != 0) return paths;
  o.part.boundary_width_mm = o.part.fill_width_mm = spacing_mm;
  o.scaffold = o.part;
  const slice::LayerPaths rings = plan_layer(r, o);
  for (std::size_t n = 0; n < rings.info.size(); ++n) {
    paths.lines.add(rings.lines[n]);
    paths.info.push_back({PathKind::kMeasurement, rings.info[n].material, rings.info[n].closed, 0});
  }
  return paths;
}

inline slice::PrintPaths print(int intervals, double size = 1.0, double spacing_mm = 4.0) {
  slice::PrintPaths p;
  p.head.materials = {{"part", "water"}, {"scaffold", "scaffold"}};
  for (int n = 1; n <= kInterval_layers * intervals; ++n) p.layers.push_back(layer(n, size, spacing_mm));
  return p;
}

}  // namespace firn::ice_gear
