#include "core/grid/material_columns.h"

#include <algorithm>

namespace firn {

void MaterialColumns::add(std::size_t cell, double thickness_mm, Material material) {
  if (!(thickness_mm > 0.0)) return;
  std::vector<MaterialSegment>& column = columns_[cell];
  const double top = top_mm(cell) + thickness_mm;
  if (!column.empty() && column.back().material == material)
    column.back().top_mm = top;
  else
    column.push_back({top, material});
}

Material MaterialColumns::at(std::size_t cell, double z_mm) const {
  const auto& column = columns_[cell];
  const auto s = std::upper_bound(column.begin(), column.end(), z_mm,
                                  [](double z, const MaterialSegment& m) { return z < m.top_mm; });
  return s == column.end() ? Material::kNone : s->material;
}

Material MaterialColumns::most(std::size_t cell, double from_mm, double to_mm) const {
  double share_a = 0.0, share_b = 0.0, below = 0.0;
  for (const MaterialSegment& s : columns_[cell]) {
    const double part = std::min(s.top_mm, to_mm) - std::max(below, from_mm);
    if (part > 0.0) (s.material == Material::kA ? share_a : share_b) += part;
    below = s.top_mm;
    if (below >= to_mm) break;
  }
  const double air = (to_mm - from_mm) - share_a - share_b;
  if (share_a >= share_b && share_a >= air) return Material::kA;
  return share_b >= air ? Material::kB : Material::kNone;
}

}  // namespace firn
