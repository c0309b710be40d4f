// PlantedTrial compares values identified from half-filled layers with those planted in the simulated world.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "studies/identify/identification_study.h"

namespace firn {

/// Holds the result of ten half-filled layers on the plant "lu2015" with planted h1..h3 and droplets (1 + v
/// U[0,1]) times as large.
struct PlantedTrial {
  double truth_mm[4] = {}, ours_mm[4] = {}, sigma_mm[4] = {};  ///< h1, h2, h3, h1 + 4 h2 + 4 h3
  double error(int n) const { return ours_mm[n] / truth_mm[n] - 1.0; }
  double z(int n) const { return (ours_mm[n] - truth_mm[n]) / sigma_mm[n]; }
};
struct PlantedTotals {
  int trials = 0;
  double worst_error[4] = {};  ///< |error|
  double mean_z[4] = {};       ///< 0 where there is no bias
  double worst_z = 0.0;        ///< |z| of all four
  int within_3_sigma[4] = {}, covered[4] = {};
};

/// @param file experiments/excitation.toml
inline PlantedTrial planted_trial(const std::string& file, std::uint64_t seed, double variation) {
  const std::string s = std::to_string(seed);
  // The plant prints with Table I; the prior values lie up to 20 % off, differently for every seed.
  const auto off = [&](std::uint32_t n) {
    return 0.8 + 0.4 * random_uniform({seed, Purpose::kInstance, 0, 0, n});
  };
  const ObservedRun run =
      observe_print(file, {"plant.model=lu2015", "plant.seed=" + s, "control.pattern.seed=" + s,
                           "plant.variation=" + std::to_string(variation), "estimator.droplets=off",
                           "model.h1_mm=" + std::to_string(0.0044 * off(0)),
                           "model.h2_mm=" + std::to_string(0.0006 * off(1)),
                           "model.h3_mm=" + std::to_string(0.0002 * off(2))});
  const droplet::Estimate e = run.learn().all;
  const double mean = 1.0 + 0.5 * variation;
  const deposition::DropletModel planted{0.0044 * mean, 0.0006 * mean, 0.0002 * mean};
  return {{planted.h1_mm, planted.h2_mm, planted.h3_mm, planted.layer_height_mm()},
          {e.model.h1_mm, e.model.h2_mm, e.model.h3_mm, e.model.layer_height_mm()},
          {e.std_mm(0), e.std_mm(1), e.std_mm(2), e.layer_height_std_mm()}};
}

inline PlantedTotals totals_of(const std::vector<PlantedTrial>& trials) {
  PlantedTotals t;
  for (const PlantedTrial& trial : trials) {
    ++t.trials;
    for (int n = 0; n < 4; ++n) {
      const double z = std::abs(trial.z(n));
      t.mean_z[n] += trial.z(n) / double(trials.size());
      t.worst_error[n] = std::max(t.worst_error[n], std::abs(trial.error(n)));
      t.worst_z = std::max(t.worst_z, z);
      t.within_3_sigma[n] += z <= 3.0;
      t.covered[n] += z <= 1.959964;
    }
  }
  return t;
}

}  // namespace firn
