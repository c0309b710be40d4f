#include "report/run/voxels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace firn::report {

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
  double top = geometry.height_mm() + slice_mm;
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

namespace {

// Fills from voxel `from` over neighbours by face that may be entered, marking them in `seen`. Returns their
// number.
template <class May>
std::int64_t fill(const VoxelBlock& v, std::size_t from, const May& may, std::vector<std::uint8_t>& seen) {
  const std::size_t nx = std::size_t(v.grid.nx), layer = v.grid.size();
  std::vector<std::size_t> open{from};
  seen[from] = 1;
  std::int64_t found = 0;
  while (!open.empty()) {
    const std::size_t at = open.back();
    open.pop_back();
    ++found;
    const auto visit = [&](bool exists, std::size_t next) {
      if (!exists || seen[next] || !may(v.cells[next])) return;
      seen[next] = 1;
      open.push_back(next);
    };
    const std::size_t i = at % nx, in_layer = at % layer;
    visit(i > 0, at - 1);
    visit(i + 1 < nx, at + 1);
    visit(in_layer >= nx, at - nx);
    visit(in_layer + nx < layer, at + nx);
    visit(at >= layer, at - layer);
    visit(at + layer < v.cells.size(), at + layer);
  }
  return found;
}

bool on_surface(const VoxelBlock& v, std::size_t n) {  // the substrate is no way out
  const std::size_t nx = std::size_t(v.grid.nx), layer = v.grid.size(), in_layer = n % layer, i = n % nx;
  return i == 0 || i + 1 == nx || in_layer < nx || in_layer + nx >= layer || n + layer >= v.cells.size();
}

}  // namespace

Washed wash(const VoxelBlock& v) {
  Washed w;
  std::vector<std::uint8_t> seen(v.cells.size(), 0);
  const auto object = [](Material m) { return m == Material::kA; };
  const auto passable = [](Material m) { return m != Material::kA; };
  for (std::size_t n = 0; n < v.cells.size(); ++n) {
    w.object += v.cells[n] == Material::kA;
    w.support += v.cells[n] == Material::kB;
    if (!seen[n] && object(v.cells[n])) w.largest_piece = std::max(w.largest_piece, fill(v, n, object, seen));
  }
  std::fill(seen.begin(), seen.end(), std::uint8_t{0});
  for (std::size_t n = 0; n < v.cells.size(); ++n)
    if (!seen[n] && passable(v.cells[n]) && on_surface(v, n)) fill(v, n, passable, seen);
  for (std::size_t n = 0; n < v.cells.size(); ++n)
    w.support_shut_in += v.cells[n] == Material::kB && !seen[n];
  return w;
}

}  // namespace firn::report
