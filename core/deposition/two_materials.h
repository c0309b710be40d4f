// TwoMaterialChange computes the height change of a layer printed with two inks [Lu 2015, Eqs. (6), (7), with
// the errata's corrections].
//
// A droplet on cell c carries the constants of its own ink, h1|c .. h3|c: h1, h2, h3 where c is in I_A, g1,
// g2, g3 where it is in I_B. It raises a neighbour n by w|c sat_{h1|c + w|c}(H_c - H_n) and keeps the rest of
// its h1|c + 4 h2|c + 4 h3|c. The errata's corrections: (6) prints the new height, not its change; in (7)
// every threshold of C1 is the droplet's own, |i,j,k on both terms, the last corner compares H_{i,j,k} with
// H_{i-1,j-1,k}; in C2 the thresholds are (h1 + h2)|neighbour and every difference is neighbour less centre.
// With one ink (7) is (4).
#pragma once

#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/material.h"
#include "core/grid/material_columns.h"

namespace firn::deposition {

/// The constants of the two inks.
struct TwoInks {
  DropletModel a;  ///< h1, h2, h3: object
  DropletModel b;  ///< g1, g2, g3: support
  const DropletModel& of(Material m) const { return m == Material::kB ? b : a; }
  bool operator==(const TwoInks&) const = default;
};

/// Eq. (7) on one grid, with its workspace.
class TwoMaterialChange {
 public:
  /// @throws std::invalid_argument: see HeightChange and check(DropletModel)
  TwoMaterialChange(const GridSpec& grid, const TwoInks& inks, Border border);

  /// Adds `drops`, each of its cell's ink, pass by pass as HeightChange::deposit. @throws
  /// std::invalid_argument before anything is changed: sizes differ from the grid, a height not finite,
  /// droplets on a cell without ink.
  Ledger deposit(HeightMap& height, const DropletPattern& drops, const MaterialMap& inks);

  /// As deposit(), and books each ink's share of every cell's rise in `columns`: dH is linear in the droplets
  /// for given heights, so each ink has its own dH. In one pass a cell's own ink lies below the ink that
  /// flows in.
  Ledger deposit(HeightMap& height, const DropletPattern& drops, const MaterialMap& inks,
                 MaterialColumns& columns);

  const TwoInks& inks() const { return inks_; }

 private:
  void load(const HeightMap& height, const DropletPattern& drops, const MaterialMap& inks);

  TwoInks inks_;
  Stencil<1> stencil_[2];
  HeightChange<1> model_;
  std::vector<Stencil<1>> stencils_;
};

/// Adds the droplets of either ink with these `stencils` to the columns in one pass on `height` (before it):
/// for models that draw each droplet's size. Changes `height` as HeightChange::step does.
Ledger step_with_columns(HeightChange<1>& model, HeightMap& height, std::span<const std::uint8_t> drops,
                         int pass, std::span<const Stencil<1>> stencils, const MaterialMap& inks,
                         MaterialColumns& columns);

/// Eq. (6), the additive baseline on flat ground with two inks; see deposit_additive().
Ledger deposit_additive(HeightMap& height, const DropletPattern& drops, const MaterialMap& inks,
                        const TwoInks& model);

}  // namespace firn::deposition
