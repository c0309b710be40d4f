// The judged cells of a layer of an ice print.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/slice/coverage/footprint.h"
#include "core/slice/paths/path_plan.h"
#include "report/run/report_ice_data.h"

using namespace firn;

namespace {

std::vector<geometry::Point> wheel(double radius_mm, double tooth_mm, int teeth) {
  std::vector<geometry::Point> ring;
  for (int n = 0; n < 480; ++n) {
    const double a = 2.0 * 3.14159265358979 * n / 480,
                 r = radius_mm + 0.5 * tooth_mm * std::tanh(2.0 * std::cos(teeth * a));
    ring.push_back({std::int32_t(std::lround(r * std::cos(a) * geometry::kUnitsPerMm)),
                    std::int32_t(std::lround(r * std::sin(a) * geometry::kUnitsPerMm))});
  }
  return ring;
}

// A toothed wheel with a bore of 9 mm, in a ring of scaffold.
slice::LayerRegions layer_regions() {
  slice::LayerRegions r;
  r.layer = 5;
  r.z = 5 * 2400;
  r.height = 2400;
  geometry::Region part, scaffold;
  std::vector<geometry::Point> bore = wheel(9.0, 0.0, 1), outline = wheel(24.0, 5.0, 12);
  std::reverse(bore.begin(), bore.end());
  part.add(outline);
  part.add(bore);
  scaffold.add(wheel(31.0, 0.0, 1));
  std::reverse(outline.begin(), outline.end());
  scaffold.add(outline);
  r.by_material = {part, scaffold};
  return r;
}

}  // namespace

TEST_CASE(
    "A layer is judged everywhere but for two millimetres at its border: no spot between beads is left out") {
  slice::PathOptions options;
  const slice::LayerPaths layer = plan_layer(layer_regions(), options);
  for (const double pitch : {1.0, 0.5}) {
    const GridSpec g = slice::footprint_grid(layer, pitch);
    const Mask footprint = slice::footprint_mask(slice::footprint_materials(layer, g)),
               judged = replay::judged_cells(layer, g);
    int inside = 0, left_out = 0, outside = 0, spots = 0;
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        const double r = std::hypot(g.x_mm(i), g.y_mm(j));
        const bool well_inside = r > 9.0 + 1.5 && r < 31.0 - 1.95;
        inside += well_inside;
        left_out += well_inside && !judged.at(i, j);
        spots += well_inside && !footprint.at(i, j);
        outside += judged.at(i, j) && (r < 9.0 - 0.2 || r > 31.0 + 0.2);
      }
    INFO("pitch " << pitch << " spots " << spots);
    CHECK(inside > 2000);
    CHECK(spots > 0);
    CHECK(left_out == 0);
    CHECK(outside == 0);
  }
}

TEST_CASE("The true error of a layer counts what lies in a spot between beads") {
  slice::PathOptions options;
  const slice::LayerPaths layer = plan_layer(layer_regions(), options);
  const GridSpec g = slice::footprint_grid(layer, 1.0);
  HeightMap field({10 * g.nx, 10 * g.ny, 0.1, 0.1, g.origin_x_mm - 0.45, g.origin_y_mm - 0.45}, 1.2);
  CHECK(replay::ice_error(field, layer, 1.0).rms_mm == Approx(0.0).margin(1e-12));
  const Mask footprint = slice::footprint_mask(slice::footprint_materials(layer, g)),
             judged = replay::judged_cells(layer, g);
  std::int64_t spots = 0, cells = 0;
  for (int j = 0; j < field.spec.ny; ++j)
    for (int i = 0; i < field.spec.nx; ++i) {
      const int a = i / 10, b = j / 10;
      const bool spot = judged.at(a, b) && !footprint.at(a, b);
      spots += spot;
      cells += judged.at(a, b);
      if (spot) field.at(i, j) -= 0.5;
    }
  REQUIRE(spots > 0);
  CHECK(replay::ice_error(field, layer, 1.0).rms_mm ==
        Approx(0.5 * std::sqrt(double(spots) / double(cells))));
}
