#include "core/control/open_loop.h"

#include <algorithm>
#include <cmath>

#include "core/control/rim_inset.h"

namespace firn::control {

OpenLoop::OpenLoop(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      inset_(inset_places(setup, options.rim_inset)),
      predict_(setup),
      layers_of_cell_(setup.grid) {
  const int fixed = options.open_loop.layers;
  check_options("open_loop", kOpenLoopOptions, options.open_loop);
  const double step_mm = setup.model.layer_height_mm();
  for (std::size_t c = 0; c < setup.grid.size(); ++c) {
    if (!setup.mask.cells[c]) continue;
    layers_of_cell_.cells[c] = fixed > 0 ? fixed : std::int32_t(setup.target.cells[c] / step_mm + 0.5);
    layers_ = std::max(layers_, int(layers_of_cell_.cells[c]));
  }
}

Decision OpenLoop::decide(const Measurement& m) {
  check(m, setup_);
  Decision d;
  d.drops = DropletPattern(setup_.grid);
  const int layer = m.layer + 1;
  for (std::size_t c = 0; c < d.drops.size(); ++c) d.drops.cells[c] = layers_of_cell_.cells[c] >= layer;
  d.materials = materials_at(setup_, double(m.layer) * setup_.model.layer_height_mm());
  d.offsets = inset_;
  d.kind = layer <= layers_ ? Decision::Kind::kPrint : Decision::Kind::kEnd;
  d.reason = layer <= layers_
                 ? "layer " + std::to_string(layer) + " of " + std::to_string(layers_) + " as sliced"
                 : "all " + std::to_string(layers_) + " sliced layers are printed";
  predict_.score(d, known_heights(m), 1.0);
  return d;
}

}  // namespace firn::control
