// Worlds whose saved state is short, for the fuzz target of states and its seeds.
#pragma once

#include "config/experiment.h"
#include "plant/world/setup.h"

namespace firn::fuzz {

inline plant::WorldConfig small_inkjet_world() {
  Experiment e;
  e.grid.nx = e.grid.ny = 4;
  plant::WorldConfig c = plant::world_config(e);
  c.droplet.fine_cells = 1;
  c.droplet.margin_cells = 2;
  return c;
}

inline plant::WorldConfig small_ice_world() {
  Experiment e;
  e.lab.kind = "ice";
  e.plant.ice.cell_mm = 0.6;
  e.plant.ice.field_width_mm = e.plant.ice.field_depth_mm = 5.0;
  return plant::world_config(e);
}

}  // namespace firn::fuzz
