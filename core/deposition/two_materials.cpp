#include "core/deposition/two_materials.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace firn::deposition {
namespace {

constexpr double kRounding_mm = 1e-12;  // less is the rounding of a difference of heights, no ink

void check_inks(const HeightMap& height, const DropletPattern& drops, const MaterialMap& inks) {
  if (height.size() != drops.size() || height.size() != inks.size())
    throw std::invalid_argument("two materials: height, drops and inks differ in size");
  const std::size_t nx = std::size_t(std::max(1, height.spec.nx));
  for (std::size_t c = 0; c < inks.size(); ++c)
    if (inks.cells[c] > std::uint8_t(Material::kB) || (drops.cells[c] && inks.of(c) == Material::kNone))
      throw std::invalid_argument("two materials: cell (" + std::to_string(c % nx) + ", " +
                                  std::to_string(c / nx) + ") has droplets and ink " +
                                  std::to_string(inks.cells[c]) + ", neither A (1) nor B (2)");
}

}  // namespace

TwoMaterialChange::TwoMaterialChange(const GridSpec& grid, const TwoInks& inks, Border border)
    : inks_(inks),
      stencil_{stencil_of(inks.a), stencil_of(inks.b)},
      model_(grid, stencil_of(inks.a), border),
      stencils_(grid.size()) {
  check(inks.a);
  check(inks.b);
}

void TwoMaterialChange::load(const HeightMap& height, const DropletPattern& drops, const MaterialMap& inks) {
  if (height.size() != model_.grid().size())
    throw std::invalid_argument("two materials: the map's size is not the grid's");
  check_inks(height, drops, inks);
  check_finite(height, "two materials");
  for (std::size_t c = 0; c < stencils_.size(); ++c) stencils_[c] = stencil_[inks.of(c) == Material::kB];
}

Ledger TwoMaterialChange::deposit(HeightMap& height, const DropletPattern& drops, const MaterialMap& inks) {
  load(height, drops, inks);
  Ledger sum;
  for (int pass = 0, n = drops.passes(); pass < n; ++pass)
    sum += model_.step(height.data(), drops.data(), pass, stencils_);
  return sum;
}

Ledger TwoMaterialChange::deposit(HeightMap& height, const DropletPattern& drops, const MaterialMap& inks,
                                  MaterialColumns& columns) {
  load(height, drops, inks);
  Ledger sum;
  for (int pass = 0, n = drops.passes(); pass < n; ++pass)
    sum += step_with_columns(model_, height, drops.cells, pass, stencils_, inks, columns);
  return sum;
}

Ledger step_with_columns(HeightChange<1>& model, HeightMap& height, std::span<const std::uint8_t> drops,
                         int pass, std::span<const Stencil<1>> stencils, const MaterialMap& inks,
                         MaterialColumns& columns) {
  const HeightMap before = height;
  HeightMap only_a = height;
  std::vector<std::uint8_t> drops_a(drops.begin(), drops.end());
  for (std::size_t c = 0; c < drops_a.size(); ++c)
    if (inks.of(c) == Material::kB) drops_a[c] = 0;
  HeightChange<1> of_a(model.grid(), model.stencil(), model.border());
  of_a.step(only_a.data(), drops_a.data(), pass, stencils);
  const Ledger ledger = model.step(height.data(), drops.data(), pass, stencils);
  for (std::size_t c = 0; c < height.size(); ++c) {
    const double of[2] = {only_a.cells[c] - before.cells[c], height.cells[c] - only_a.cells[c]};
    const bool b_first = drops[c] > pass && inks.of(c) == Material::kB;
    for (const bool b : {b_first, !b_first})
      if (of[b] > kRounding_mm) columns.add(c, of[b], b ? Material::kB : Material::kA);
  }
  return ledger;
}

Ledger deposit_additive(HeightMap& height, const DropletPattern& drops, const MaterialMap& inks,
                        const TwoInks& model) {
  check_inks(height, drops, inks);
  Ledger sum;
  for (const Material m : {Material::kA, Material::kB}) {
    DropletPattern of_ink = drops;
    for (std::size_t c = 0; c < of_ink.size(); ++c)
      if (inks.of(c) != m) of_ink.cells[c] = 0;
    sum += deposit_additive(height, of_ink, model.of(m));
  }
  return sum;
}

}  // namespace firn::deposition
