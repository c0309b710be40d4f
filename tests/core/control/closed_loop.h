// Computes a print in a loop of one function: controller against the height-change model itself, with varied
// droplets and measurement noise. For tests and benches of controllers; the independent plant is plant/.
#pragma once

#include <cstdint>
#include <vector>

#include "core/control/controller.h"
#include "core/grid/shapes.h"

namespace firn::control {

struct LoopConditions {
  double variation = 0.0;     ///< h1..h3 of each droplet times 1 + variation * U[0, 1)
  double noise_std_mm = 0.0;  ///< of each measured height
  double roughness_mm = 0.0;  ///< substrate heights uniform in [0, roughness)
  std::uint64_t seed = 1;
  int most_layers = 300;
};

struct LoopResult {
  HeightMap height;  ///< true surface at the end
  int layers = 0;
  bool ended = false;  ///< by the controller
  std::int64_t drops = 0;
  ErrorStats stats;  ///< height - target on the mask
  std::vector<Decision> decisions;
};

LoopResult run_loop(LayerController& controller, const Setup& setup, const LoopConditions& conditions);

/// Lu's lab: 40 x 40 cells of 0.263256 mm and a cylinder.
Setup cylinder_setup(double diameter_cells = 37.0, double height_mm = 0.4);

}  // namespace firn::control
