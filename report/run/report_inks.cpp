#include "report/run/report_inks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "report/draw/raster.h"
#include "report/draw/svg.h"
#include "report/run/block_view.h"
#include "report/run/voxels.h"

namespace firn::report {
namespace {

constexpr int kSlices = 24;            // of a block in its pictures
constexpr std::size_t kInksShown = 6;  // layers

// As in the pictures of the block.
Rgba ink_color(Material m) {
  switch (m) {
    case Material::kA:
      return {58, 128, 186, 255};
    case Material::kB:
      return {233, 222, 190, 255};
    default:
      return {0, 0, 0, 0};
  }
}

std::string mask_pictures(const InkLayer& layer, const std::string& title) {
  constexpr double kWide = 190, kGap = 14, kTop = 20;
  const GridSpec& g = layer.wanted.spec;
  const double high = kWide * g.ny / g.nx;
  std::string s = svg_open(2 * kWide + kGap, kTop + high + 2, title);
  double left = 0;
  for (const MaterialMap* map : {&layer.wanted, &layer.planned}) {
    Raster raster(g.nx, g.ny);
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) raster.at(i, g.ny - 1 - j) = ink_color(map->of(g.index(i, j)));
    s += svg_text(left, kTop - 7, "start", "tick", map == &layer.wanted ? "wanted" : "printed") +
         svg_image(raster, left, kTop, kWide, high);
    left += kWide + kGap;
  }
  return s + "</svg>\n";
}

std::int64_t cells_of(const MaterialMap& map, Material m) {
  return std::count(map.cells.begin(), map.cells.end(), std::uint8_t(m));
}

std::int64_t cells_against(const InkLayer& l) {
  std::int64_t n = 0;
  for (std::size_t c = 0; c < l.planned.size(); ++c)
    n += l.planned.of(c) != Material::kNone && l.planned.of(c) != l.wanted.of(c);
  return n;
}

std::string layers_of(const NamedInks& run) {
  const std::vector<InkLayer>& all = run.data->layers;
  const std::size_t shown = std::min(kInksShown, all.size());
  std::string s = "<div class=\"row\">\n";
  for (std::size_t n = 0; n < shown; ++n) {
    const InkLayer& l = all[shown > 1 ? n * (all.size() - 1) / (shown - 1) : 0];
    const std::string at = "layer " + std::to_string(l.layer) + ", " + number(l.height_mm * 1e3, 1) + " µm";
    s += "<figure><figcaption>" + at + ": " + std::to_string(cells_of(l.planned, Material::kA)) +
         " cells of object ink, " + std::to_string(cells_of(l.planned, Material::kB)) + " of support, " +
         std::to_string(cells_against(l)) + " against the mask</figcaption>\n" +
         mask_pictures(l, "inks of " + at) + "</figure>\n";
  }
  return s + "</div>\n";
}

}  // namespace

std::optional<InkData> read_ink_data(const runs::RunMessages& messages, std::span<const std::byte> geometry,
                                     const Mask& block) {
  const GridSpec& grid = block.spec;
  InkData data{geometry_from_bytes(geometry, grid, "geometry"), MaterialColumns(grid), {}};
  std::map<std::int32_t, HeightMap> surfaces;  // by layers deposited so far; the last attempt of each
  std::map<std::int32_t, MaterialMap> planned;
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    surfaces.insert_or_assign(m.layer, height_of(m));
  });
  messages.each<layer_plan_t>(channels::kLayerPlan.name, [&](const layer_plan_t& m) {
    if (m.n_material > 0) planned.insert_or_assign(m.layer, materials_of(m));
  });
  for (const auto& [layer, inks] : planned) {
    const auto after = surfaces.find(layer), before = surfaces.find(layer - 1);
    if (after == surfaces.end() || before == surfaces.end() || inks.spec != grid ||
        after->second.spec != grid || before->second.spec != grid)
      continue;
    InkLayer l{layer, 0.0, inks, MaterialMap(grid)};
    std::size_t measured = 0;
    for (std::size_t c = 0; c < grid.size(); ++c) {
      const double top = after->second.cells[c], from = before->second.cells[c];
      if (block.cells[c] && std::isfinite(from)) l.wanted.set(c, data.geometry.at(c, from));
      if (!std::isfinite(top)) continue;
      if (inks.of(c) == Material::kNone) continue;
      l.height_mm += top;
      ++measured;
      data.printed.add(c, top - data.printed.top_mm(c), inks.of(c));
    }
    if (measured) l.height_mm /= double(measured);
    data.layers.push_back(std::move(l));
  }
  if (data.layers.empty()) return std::nullopt;
  return data;
}

std::string ink_sections(const std::vector<NamedInks>& runs) {
  if (runs.empty()) return "";
  std::string s =
      "<h2>Inks</h2>\n<p class=\"soft\">Object ink and support. Wanted: the object's mask at the surface "
      "that was measured before the "
      "layer. Printed: the ink that each cell's droplets were of; the block below is as thick in every layer "
      "as the measured surface "
      "rose. z is stretched.</p>\n";
  for (const NamedInks& run : runs) {
    const InkData& d = *run.data;
    const double slice_mm = d.geometry.height_mm() /
                            kSlices;  // an excess above the block's top is an error of height, not of an ink
    const VoxelBlock wanted = voxels_of(d.geometry, slice_mm, kSlices),
                     printed = voxels_of(d.printed, slice_mm, kSlices);
    const WrongVoxels wrong = count_wrong(wanted, printed);
    s += "<h3>" + escape_html(run.name) + "</h3>\n" + layers_of(run) +
         "<p></p>\n<div class=\"row\">\n<figure class=\"map\"><figcaption>Wanted and printed block: " +
         std::to_string(wrong.wrong()) + " wrong voxels of " + std::to_string(wrong.object) +
         " of the object inside, and " + std::to_string(wrong.boundary_wrong()) + " of " +
         std::to_string(wrong.object_boundary) +
         " at its surface, where the grid cannot follow it</figcaption>\n" +
         section_view(wanted, {{"wanted", &wanted}, {"printed", &printed}}, d.printed.grid().nx / 2,
                      "inks of " + run.name) +
         "</figure>\n<figure class=\"map\"><figcaption>The object as printed, support taken "
         "away</figcaption>\n" +
         block_view(wanted, printed, {}, "object of " + run.name) + "</figure>\n</div>\n";
  }
  return s;
}

}  // namespace firn::report
