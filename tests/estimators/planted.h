// Computes layers printed by the paper's own model [Lu 2015, Eqs. (3)-(5)] with planted h1..h3, droplet
// scatter and noise.
#pragma once

#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/random.h"
#include "estimators/droplet/droplet_estimator.h"

namespace firn::test {

struct Planted {
  GridSpec grid{40, 40, 0.263256, 0.263256, 0.0, 0.0};
  deposition::DropletModel model;  ///< of an average droplet
  double variation = 0.2;          ///< droplets are (1 + v U[0,1]) / (1 + v / 2) of it
  double noise_mm = 0.001;         ///< of one cell
  double fill = 0.5;
  std::uint64_t seed = 1;
  int layer = 0;
  HeightMap height{grid, 0.0};  ///< the true surface

  std::uint32_t k() const { return std::uint32_t(layer); }
  /// The next layer's droplets, deposited.
  droplet::Pass print() {
    ++layer;
    droplet::Pass pass;
    deposition::HeightChange<1> change(grid, deposition::stencil_of(model), deposition::Border::kLose);
    std::vector<deposition::Stencil<1>> stencils(grid.size(), change.stencil());
    std::vector<std::uint8_t> drops(grid.size(), 0);
    for (std::uint32_t c = 0; c < grid.size(); ++c) {
      if (random_uniform({seed, Purpose::kPattern, k(), 0, c}) >= fill) continue;
      const double factor = (1.0 + variation * random_uniform({seed, Purpose::kModelVariation, k(), 0, c})) /
                            (1.0 + 0.5 * variation);
      drops[c] = 1;
      pass.cells.push_back(c);
      stencils[c].centre_mm *= factor;
      for (double& w : stencils[c].ring_mm) w *= factor;
    }
    change.step(height.data(), drops.data(), 0, stencils);
    return pass;
  }
  HeightMap measure() const {
    HeightMap y = height;
    for (std::uint32_t c = 0; c < grid.size(); ++c)
      y.cells[c] += noise_mm * random_normal({seed, Purpose::kSensorNoise, k(), 0, c});
    return y;
  }
  std::vector<droplet::Use> everywhere() const {
    return std::vector<droplet::Use>(grid.size(), droplet::Use::kLearn);
  }
  droplet::EstimatorOptions options() const {
    droplet::EstimatorOptions o;
    o.prior = {};  // Lu's Table I
    return o;
  }
  droplet::Estimate learn(droplet::DropletEstimator& estimator, int layers) {
    if (!estimator.has_substrate()) estimator.set_substrate(measure(), everywhere(), noise_mm);
    for (int n = 0; n < layers; ++n) {
      droplet::Pass pass = print();
      estimator.add_layer({std::move(pass)}, measure(), everywhere(), noise_mm);
    }
    return estimator.estimate();
  }
};

}  // namespace firn::test
