#include "replay/voxels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace firn::replay {

VoxelBlock voxels_of(const MaterialColumns& printed, double slice_mm, int nz) {
  VoxelBlock v{printed.grid(), slice_mm, nz, {}};
  for (int k = 0; k < nz; ++k)
    for (std::size_t c = 0; c < v.grid.size(); ++c)
      v.cells.push_back(printed.most(c, k * slice_mm, (k + 1) * slice_mm));
  return v;
}

VoxelBlock voxels_of(const Geometry& geometry, double slice_mm, int nz) {
  VoxelBlock v{geometry.grid(), slice_mm, nz, {}};
  for (int k = 0; k < nz; ++k)
    for (std::size_t c = 0; c < v.grid.size(); ++c) {
      const double from = k * slice_mm, to = (k + 1) * slice_mm;
      double filled = 0.0;
      for (const Span& s : geometry.spans(c))
        filled += std::max(0.0, std::min(s.to_mm, to) - std::max(s.from_mm, from));
      const bool in_block = geometry.height_mm() - from >= 0.5 * slice_mm * (1.0 - 1e-9);
      v.cells.push_back(filled >= 0.5 * slice_mm ? Material::kA : in_block ? Material::kB : Material::kNone);
    }
  return v;
}

int slices_for(const MaterialColumns& printed, const Geometry& geometry, double slice_mm) {
  double top = geometry.height_mm();
  for (std::size_t c = 0; c < printed.grid().size(); ++c) top = std::max(top, printed.top_mm(c));
  return int(std::ceil(top / slice_mm - 1e-9));
}

WrongVoxels count_wrong(const VoxelBlock& wanted, const VoxelBlock& printed) {
  if (wanted.grid.size() != printed.grid.size() || wanted.nz != printed.nz)
    throw std::invalid_argument("voxels: the wanted and the printed block differ in shape");
  WrongVoxels n;
  const GridSpec& g = wanted.grid;
  for (int k = 0; k < wanted.nz; ++k)
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        const bool object = wanted.at(i, j, k) == Material::kA;
        bool boundary = false;
        for (int dk = -1; dk <= 1 && !boundary; ++dk)
          for (int dj = -1; dj <= 1; ++dj)
            for (int di = -1; di <= 1; ++di)
              if (g.contains(i + di, j + dj) && k + dk >= 0 && k + dk < wanted.nz)
                boundary = boundary || (wanted.at(i + di, j + dj, k + dk) == Material::kA) != object;
        if (object) ++(boundary ? n.object_boundary : n.object);
        if ((printed.at(i, j, k) == Material::kA) == object) continue;
        ++(object ? (boundary ? n.boundary_inside : n.inside) : (boundary ? n.boundary_outside : n.outside));
      }
  return n;
}

}  // namespace firn::replay
