// Returns a small print for the nodes of the ice lab: a block of ice in a frame of scaffold, laid in rings.
#pragma once

#include <cmath>

#include "config/experiment.h"
#include "config/machine.h"
#include "core/slice/paths/print_paths.h"

namespace firn::test {

inline Machine cobra() { return parse_machine("[machine]\nname = \"cobra600\"\n", "machine"); }

inline Experiment ice_experiment() {
  Experiment e;
  e.lab.kind = "ice";
  e.control.scheme = "smf";
  e.control.smf = {};
  e.control.smf.kp = 1.0;
  e.control.smf.ki_star = 0.25;
  e.control.smf.kd_star = 0.25;
  e.control.smoothing = 1.0;
  return e;
}

inline geometry::Point ice_point(double x_mm, double y_mm) {
  return {std::int32_t(std::lround(x_mm * geometry::kUnitsPerMm)),
          std::int32_t(std::lround(y_mm * geometry::kUnitsPerMm))};
}

/// Square rings about the origin, `spacing` apart, from half a spacing inside `half` down to `inner`.
inline void add_rings(slice::LayerPaths& l, double half_mm, double inner_mm, double spacing_mm, PathKind kind,
                      std::uint8_t material) {
  for (double r = half_mm - 0.5 * spacing_mm; r > inner_mm; r -= spacing_mm) {
    std::vector<geometry::Point> ring;
    for (int side = 0; side < 4; ++side)
      for (int k = 0; k < 8; ++k) {
        const double t = -r + 2.0 * r * k / 8.0;
        ring.push_back(side == 0   ? ice_point(t, -r)
                       : side == 1 ? ice_point(r, t)
                       : side == 2 ? ice_point(-t, r)
                                   : ice_point(-r, -t));
      }
    l.lines.add(ring);
    l.info.push_back(
        {kind, material, true,
         kind == PathKind::kMeasurement ? 0 : std::int32_t(std::lround(spacing_mm * geometry::kUnitsPerMm))});
  }
}

/// A block of 11 mm of one layer an interval, without scaffold.
inline slice::PrintPaths ice_block(int intervals) {
  slice::PrintPaths p;
  p.head = {"test", intervals, {{"part", "water"}, {"scaffold", "scaffold"}}, "laser", ""};
  for (int n = 1; n <= intervals; ++n) {
    slice::LayerPaths l;
    l.layer = n;
    l.z = 2400 * n;
    l.height = 2400;
    add_rings(l, 5.5, 0.0, 1.5, n % 2 ? PathKind::kFill : PathKind::kBoundary, 0);
    add_rings(l, 5.7, 0.0, 1.5, PathKind::kMeasurement, 0);
    p.layers.push_back(l);
  }
  return p;
}

/// `layers` of 0.24 mm: ice within +-12 mm, scaffold to +-15 mm; measured every `every` layers on rings 3 mm
/// apart.
inline slice::PrintPaths ice_print(int layers = 10, int every = 5) {
  slice::PrintPaths p;
  p.head = {"test", layers, {{"part", "water"}, {"scaffold", "scaffold"}}, "laser", ""};
  for (int n = 1; n <= layers; ++n) {
    slice::LayerPaths l;
    l.layer = n;
    l.z = 2400 * n;
    l.height = 2400;
    add_rings(l, 12.0, 0.0, 1.5, n % 2 ? PathKind::kFill : PathKind::kBoundary, 0);
    add_rings(l, 15.0, 12.0, 1.5, PathKind::kBoundary, 1);
    if (n % every == 0) {
      add_rings(l, 12.5, 0.0, 2.0, PathKind::kMeasurement, 0);
      add_rings(l, 15.2, 12.2, 1.5, PathKind::kMeasurement, 1);
    }
    p.layers.push_back(l);
  }
  return p;
}

}  // namespace firn::test
