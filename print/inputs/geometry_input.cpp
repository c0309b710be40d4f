#include "print/inputs/geometry_input.h"

#include <algorithm>
#include <vector>

#include "config/error.h"
#include "core/grid/png.h"
#include "files/usage_error.h"
#include "print/inputs/targets.h"

namespace firn {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& key, const std::string& problem) {
  throw ConfigError(file, 0, key, key + ": " + problem);
}

std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error))
    refuse(folder.string(), "geometry.images", "no such folder");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  if (files.empty()) refuse(folder.string(), "geometry.images", "no *.png in it");
  if (files.size() > std::size_t(kMaxGridSide))
    refuse(folder.string(), "geometry.images",
           std::to_string(files.size()) + " images are above the limit of " + std::to_string(kMaxGridSide));
  std::sort(files.begin(), files.end());
  return files;
}

// All pictures of a stack have the columns and rows of the first, so that all have its size.
ImageStack load_stack(const Experiment& e, const std::filesystem::path& folder) {
  std::vector<Mask> layers;
  PixelSize pixel;
  PngHeader first;
  for (const std::filesystem::path& file : images_in(folder)) {
    const std::vector<std::byte> png = read_bytes(file, "geometry.images");
    if (layers.empty()) pixel = layer_pixel_size(e.part, png, file.string());
    layers.push_back(layer_from_png(png, e.grid, pixel, file.string()));
    const PngHeader header = png_header(png);
    if (layers.size() == 1) first = header;
    if (header.width != first.width || header.height != first.height)
      refuse(file.string(), "geometry.images",
             std::to_string(header.width) + " x " + std::to_string(header.height) +
                 " pixels, where the first picture has " + std::to_string(first.width) + " x " +
                 std::to_string(first.height));
  }
  return ImageStack(e.grid, e.geometry.image_pitch_z_mm, std::move(layers));
}

Geometry load_mesh(const Experiment& e, const std::filesystem::path& folder, double height_mm,
                   const MeshInputs* meshes) {
  if (!meshes) throw UsageError("geometry.shape = \"mesh\": this program reads no meshes; firn print does");
  return meshes->geometry(e, folder, height_mm);
}

}  // namespace

std::optional<Geometry> make_geometry(const Experiment& e, const HeightMap& target,
                                      const std::filesystem::path& folder, const MeshInputs* meshes) {
  const std::string& kind = e.geometry.solid.kind;
  if (kind == "none") return std::nullopt;
  const double height_mm = *std::max_element(target.cells.begin(), target.cells.end());
  const double step_mm = 0.25 * (e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm);
  try {
    Geometry g =
        kind == "mesh" ? load_mesh(e, folder, height_mm, meshes)
        : kind == "images"
            ? Geometry::sampled(load_stack(e, folder / e.geometry.images), e.grid, height_mm, step_mm)
            : Geometry::sampled(*make_solid(e.geometry.solid, e.grid), e.grid, height_mm, step_mm);
    bool any = false;
    for (std::size_t c = 0; c < e.grid.size(); ++c) any = any || !g.spans(c).empty();
    if (!any) refuse("geometry", "geometry.shape", "no part of the object lies in the block");
    return g;
  } catch (const std::invalid_argument& error) {
    refuse("geometry", "geometry.shape", error.what());
  }
}

}  // namespace firn
