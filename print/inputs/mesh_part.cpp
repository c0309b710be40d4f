#include "print/inputs/mesh_part.h"

#include <fmt/core.h>

#include <algorithm>

#include "config/error.h"
#include "core/slice/mesh/columns.h"
#include "files/usage_error.h"

namespace firn {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& key, const std::string& problem) {
  throw ConfigError(file, 0, key, key + ": " + problem);
}

MeshFile opened(const std::filesystem::path& file, const std::string& key, FacetCount count) try {
  return MeshFile(file, count);
} catch (const UsageError& error) {
  refuse(file.string(), key, error.what());
}

slice::Placement centred(double unit_mm, double scale_xy, double scale_z, double z_mm) {
  using Mode = slice::AxisPlace::Mode;
  slice::Placement p;
  p.unit_mm = unit_mm;
  p.scale = {scale_xy, scale_xy, scale_z};
  p.translation = {{{Mode::kCentre, 0.0}, {Mode::kCentre, 0.0}, {Mode::kNumber, z_mm}}};
  return p;
}

BoxSize size_of(const slice::Affine& a) {
  return {(double(a.high.x) - a.low.x) * geometry::kMmPerUnit,
          (double(a.high.y) - a.low.y) * geometry::kMmPerUnit,
          (double(a.high.z) - a.low.z) * geometry::kMmPerUnit};
}

}  // namespace

std::string box_text(const BoxSize& s) {
  return fmt::format("{:.6g} x {:.6g} x {:.6g} mm", s[0], s[1], s[2]);
}

MeshPart::MeshPart(const std::filesystem::path& file, const std::string& key, double scale_xy, double scale_z,
                   double z_mm, FacetCount count)
    : mesh_(opened(file, key, count)) {
  try {
    affine_ =
        slice::place(mesh_.facets(), centred(mesh_.data().mm_per_unit, scale_xy, scale_z, z_mm), serially);
  } catch (const std::invalid_argument& error) {
    refuse(file.string(), key, error.what());
  }
  if (affine_.low.x > affine_.high.x) refuse(file.string(), key, "no facet is finite");
  size_mm_ = size_of(affine_);
}

std::vector<std::vector<Span>> MeshPart::columns(const GridSpec& grid, double height_mm) const {
  GridSpec about_middle = grid;  // the mesh is centred on 0, the grid may lie anywhere
  about_middle.origin_x_mm = -0.5 * (grid.nx - 1) * grid.pitch_x_mm;
  about_middle.origin_y_mm = -0.5 * (grid.ny - 1) * grid.pitch_y_mm;
  return slice::columns(slice::weld(mesh_.facets(), affine_), about_middle, height_mm);
}

void check_fits(const BoxSize& part, const BoxSize& lab, const std::string& file, const std::string& key,
                const std::string& where) {
  double factor = 1.0;
  for (int axis = 0; axis < 3; ++axis)
    factor = std::min(factor, lab[std::size_t(axis)] / part[std::size_t(axis)]);
  if (factor >= 1.0 - 1e-6) return;
  std::string units;
  for (const auto& [name, share] : {std::pair{"micrometres", 1e-3}, std::pair{"inches of 1/1000", 0.0254}})
    if (share <= factor && units.empty())
      units = fmt::format("; taken as {} it would be {}", name,
                          box_text({part[0] * share, part[1] * share, part[2] * share}));
  refuse(file, key,
         fmt::format("the part is {}, and {} is {}: a scale of at most {:.3g} fits{}", box_text(part), where,
                     box_text(lab), factor, units));
}

namespace {

Target target_from_mesh(const Experiment& e, const std::filesystem::path& folder) {
  const std::string file = (folder / e.part.mesh).string(), key = "part.mesh";
  const MeshPart mesh(file, key, e.part.mesh_scale_xy, e.part.mesh_scale_z, 0.0);
  const GridSpec& g = e.grid;
  check_fits(mesh.size_mm(), {g.nx * g.pitch_x_mm, g.ny * g.pitch_y_mm, e.stage.z_max_mm - e.stage.z_min_mm},
             file, key, "the grid, with the stage's travel in z,");
  const double layer_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm;
  Target target{HeightMap(g), Mask(g)};
  std::size_t hanging = 0;
  const auto columns = mesh.columns(g, mesh.size_mm()[2] + layer_mm);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<Span>& spans = columns[c];
    if (spans.empty()) continue;
    hanging += spans.size() > 1 || spans.front().from_mm > layer_mm;
    target.height.cells[c] = spans.back().to_mm;
    target.mask.cells[c] = 1;
  }
  if (target.mask.count() == 0) refuse(file, key, "the part covers no cell's centre");
  if (hanging > 0)
    refuse(
        file, key,
        fmt::format("{} of {} cells have air below the part, which one ink cannot print; with a second ink "
                    "as support: geometry.shape = \"mesh\", geometry.mesh",
                    hanging, target.mask.count()));
  return target;
}

Geometry geometry_from_mesh(const Experiment& e, const std::filesystem::path& folder, double height_mm) {
  const MeshPart mesh(folder / e.geometry.mesh, "geometry.mesh", e.geometry.mesh_scale_xy,
                      e.geometry.mesh_scale_z, e.geometry.mesh_z_mm);
  return Geometry(e.grid, height_mm, mesh.columns(e.grid, height_mm));
}

}  // namespace

const MeshInputs kMeshInputs{&target_from_mesh, &geometry_from_mesh};

}  // namespace firn
