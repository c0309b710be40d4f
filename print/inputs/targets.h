// Makes the inputs of a print of droplets: target and mask as NPY blobs, from an analytic shape or a grey PNG
// height map.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/inputs/mesh_inputs.h"
#include "runtime/node.h"

namespace firn {

/// Size of a pixel along x and y [mm].
struct PixelSize {
  double x_mm = 0.0, y_mm = 0.0;
};

/// Computes heights on `grid` from grey values: white (255, or 65535 of 16 bits) = `white_mm`, black =
/// no part. The picture lies in the middle of the grid, its top row at maximum y. A cell belongs to the part
/// if pixels of the part cover at least half of it, and has the mean height of these pixels, by area.
/// @param pixel none: the picture covers the grid
/// @throws ConfigError (file `name`, key part.image): not a PNG, not grey (with the command that makes it
/// so), more than kMaxGridSide a side, all black, no cell half covered, a pixel of the part beyond the grid.
Target target_from_png(std::span<const std::byte> png, const GridSpec& grid, double white_mm,
                       const std::string& name, const std::optional<PixelSize>& pixel = std::nullopt);

/// Returns the columns and rows of a picture. @throws ConfigError (file `name`, key part.image): as
/// target_from_png
std::array<int, 2> picture_pixels(std::span<const std::byte> png, const std::string& name);

/// Returns the size of the square pixels of part.image: part.um_per_px, or part.width_mm by its columns.
/// @throws ConfigError (file `name`): neither or both are given, a part.depth_mm of another aspect
PixelSize pixel_size(const PartConfig& part, std::span<const std::byte> png, const std::string& name);

/// Returns the size of the square pixels of geometry.images: part.um_per_px, else the block's width by the
/// columns of a picture.
/// @throws ConfigError (file `name`, key geometry.images): no picture, a block without a width
PixelSize layer_pixel_size(const PartConfig& part, std::span<const std::byte> png, const std::string& name);

/// Computes the cells of one layer of geometry.images that are object: at least half white on average, the
/// surroundings of the picture being black. The picture lies as in target_from_png.
/// @throws ConfigError (file `name`, key geometry.images): as target_from_png, but black pictures are layers
/// without object; a pixel beyond the grid is object if it is at least half white.
Mask layer_from_png(std::span<const std::byte> png, const GridSpec& grid, const PixelSize& pixel,
                    const std::string& name);

/// Reads the bytes of a file. @throws ConfigError (file `path`, key): not a file, unreadable.
std::vector<std::byte> read_bytes(const std::filesystem::path& path, const std::string& key);

/// Names bytes by their digest.
Blob make_blob(std::string role, std::vector<std::byte> bytes);

/// Makes the blobs "target" ('<f8'), "mask" ('|u1'), for a height map "image" (the PNG as it is) and for two
/// inks "geometry" (core/grid/geometry.h).
/// @param folder of the experiment file, to which part.image is relative.
/// @param meshes nullptr: the program reads none
/// @throws ConfigError: unreadable or wrong image, or a part that covers no cell centre; UsageError: a mesh
/// without a reader.
Blobs make_target_inputs(const Experiment& experiment, const std::filesystem::path& folder,
                         const MeshInputs* meshes);

/// Refuses inputs of a run for an experiment whose nozzle would touch the part. make_target_inputs() does so
/// by itself. @throws ConfigError
void check_target_inputs(const Experiment& experiment, const Blobs& inputs);

}  // namespace firn
