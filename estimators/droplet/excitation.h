// design_excitation() computes from fired droplets alone whether layers can distinguish h1, h2 and h3, before
// anything is fitted to the maps.
#pragma once

#include <string>
#include <vector>

#include "estimators/droplet/identification.h"

namespace firn::droplet {

struct DesignExcitation {
  /// Smallest eigenvalue of the correlation matrix of a cell's own droplets, those at its sides and those at
  /// its corners: 0 = some combination of them never varies by itself.
  double excitation = 0.0;
  bool own = false, sides = false, corners = false;  ///< some measured cell has such droplets
};
DesignExcitation design_excitation(const std::vector<PrintedLayer>& layers);

/// Returns the names of the constants that no measured cell shows ("h3"), or "" if there are none.
std::string unseen_constants(const DesignExcitation& design);

/// Height that a droplet adds to a layer far from edges, h1 + 4 h2 + 4 h3: rise per droplet of cells that
/// fired as many droplets as each of their eight neighbours; one value for each layer that has such cells.
Repeats layer_height_of_even_cells(const std::vector<PrintedLayer>& layers);

}  // namespace firn::droplet
