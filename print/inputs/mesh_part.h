// MeshPart holds a mesh as a lab without a slicer of its own prints it: its place, its size, its columns.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "core/grid/geometry.h"
#include "core/grid/shapes.h"
#include "core/slice/mesh/placement.h"
#include "files/mesh/mesh_file.h"
#include "print/inputs/mesh_inputs.h"

namespace firn {

extern const MeshInputs kMeshInputs;

/// Sides of a box [mm].
using BoxSize = std::array<double, 3>;
std::string box_text(const BoxSize& size);  ///< "4 x 3 x 0.2 mm"

class MeshPart {
 public:
  /// Reads the file, centred in x and y. @param z_mm of its lowest point
  /// @throws ConfigError (file, key): a file that is no mesh, a size that no grid holds
  MeshPart(const std::filesystem::path& file, const std::string& key, double scale_xy, double scale_z,
           double z_mm, FacetCount count = FacetCount::kAgree);

  const BoxSize& size_mm() const { return size_mm_; }
  const MeshFile& file() const { return mesh_; }
  const slice::Affine& place() const { return affine_; }
  /// Returns the intervals inside the mesh, cell by cell of `grid`, whose middle is the mesh's.
  std::vector<std::vector<Span>> columns(const GridSpec& grid, double height_mm) const;

 private:
  MeshFile mesh_;
  slice::Affine affine_;
  BoxSize size_mm_{};
};

/// Refuses a part that is larger than the lab, before anything is computed of it: a file in another unit is
/// named with the factor that would fit.
/// @param key of the mesh, named with `file`. @param lab "the grid", "the arm's reach"
/// @throws ConfigError
void check_fits(const BoxSize& part_mm, const BoxSize& lab_mm, const std::string& file,
                const std::string& key, const std::string& lab);

/// Returns remarks on a part that can be printed but may not be meant: far smaller than `detail_mm` allows,
/// as a file in inches or metres is; an open surface, whose inside is a guess; remarks of the reader.
std::vector<std::string> mesh_remarks(const std::filesystem::path& file, const std::string& key,
                                      double scale_xy, double scale_z, double detail_mm,
                                      FacetCount count = FacetCount::kAgree);

}  // namespace firn
