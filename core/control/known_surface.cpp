#include "core/control/known_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/grid/cell_quality.h"

namespace firn::control {

HeightMap KnownSurface::after(const Printed& layer) const {
  HeightMap h = layer.surface;
  if (layer.offsets.size() != 0)
    deposition::OffsetChange(grid_, offsets_, border_, offsets_b_)
        .deposit(h, layer.drops, layer.offsets, layer.materials);
  else if (layer.materials.size() != 0)
    deposition::TwoMaterialChange(grid_, inks_, border_).deposit(h, layer.drops, layer.materials);
  else
    deposition::HeightChange<1>(grid_, deposition::stencil_of(inks_.a), border_).deposit(h, layer.drops);
  return h;
}

HeightMap KnownSurface::filled(HeightMap map, std::span<const std::int8_t> quality, int layer) {
  const auto guessed = [](std::int8_t q) { return CellQuality(q) == CellQuality::kGuessed; };
  const Printed& below = last_.layer == layer ? before_ : last_;
  if (quality.size() != map.size() || layer < 1 || below.layer != layer - 1 ||
      below.surface.spec != map.spec || std::ranges::none_of(quality, guessed))
    return map;
  const HeightMap model = after(below);
  for (std::size_t c = 0; c < map.size(); ++c)
    if (guessed(quality[c])) map.cells[c] = model.cells[c];
  return map;
}

void KnownSurface::keep(HeightMap surface, int layer, DropletPattern drops, MaterialMap materials,
                        OffsetMap offsets) {
  for (double& h : surface.cells)
    if (!std::isfinite(h)) h = 0.0;  // the bare substrate beside the part
  if (layer != last_.layer) before_ = std::move(last_);
  last_ = {layer, std::move(surface), std::move(drops), std::move(materials), std::move(offsets)};
}

}  // namespace firn::control
