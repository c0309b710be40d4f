// VoxelBlock holds a block of two inks as voxels; count_wrong counts the voxels of the wrong ink [Lu 2015,
// V-A, Figs. 13-15].
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/geometry.h"
#include "core/grid/material_columns.h"

namespace firn::report {

/// Holds cells of the grid times slices of equal height, from the substrate up.
struct VoxelBlock {
  GridSpec grid;
  double slice_mm = 0.0;
  int nz = 0;
  std::vector<Material> cells;  ///< index (k * ny + j) * nx + i

  Material at(int i, int j, int k) const { return cells[std::size_t(k) * grid.size() + grid.index(i, j)]; }
  /// Returns at(), or kNone beside and above the block.
  Material at_or_none(int i, int j, int k) const {
    return grid.contains(i, j) && k >= 0 && k < nz ? at(i, j, k) : Material::kNone;
  }
};

/// Computes the printed block: each voxel has the material that fills most of it, air included.
VoxelBlock voxels_of(const MaterialColumns& printed, double slice_mm, int nz);
/// Computes the wanted block: A where M fills half of a voxel or more, B in the rest of the block, air above
/// it.
VoxelBlock voxels_of(const Geometry& geometry, double slice_mm, int nz);
/// Returns the number of slices of `slice_mm` that hold the printed block, the wanted one and air above it.
int slices_for(const MaterialColumns& printed, const Geometry& geometry, double slice_mm);

/// Holds the number of voxels that are wrong once the support is removed: within M without object ink, and
/// outside M with it. The boundary layer is the voxels that touch (by face, edge or corner) a voxel of the
/// other kind. It is counted apart, because the grid itself cannot follow M there.
struct WrongVoxels {
  std::int64_t object = 0, object_boundary = 0;  ///< wanted in M: away from the boundary layer, and in it
  std::int64_t inside = 0, outside = 0;          ///< wrong, away from the boundary layer
  std::int64_t boundary_inside = 0, boundary_outside = 0;
  std::int64_t wrong() const { return inside + outside; }
  std::int64_t boundary_wrong() const { return boundary_inside + boundary_outside; }
};
/// Counts the wrong voxels. @throws std::invalid_argument: blocks of different shape
WrongVoxels count_wrong(const VoxelBlock& wanted, const VoxelBlock& printed);

/// Holds the result of washing [Lu 2015, Fig. 15]: pieces hold together by faces.
struct Washed {
  std::int64_t object = 0;           ///< voxels of object ink
  std::int64_t largest_piece = 0;    ///< of them, in the largest piece
  std::int64_t support = 0;          ///< voxels of support
  std::int64_t support_shut_in = 0;  ///< of them, not reachable from outside through support and air
};
Washed wash(const VoxelBlock& printed);

}  // namespace firn::report
