// EstimatorOptions and HeightFilterOptions hold the options of the droplet estimators, with their tables.
#pragma once

#include "core/deposition/height_change.h"
#include "core/options/option.h"

namespace firn::droplet {

struct EstimatorOptions {
  deposition::DropletModel prior;  ///< estimate before the first layer
  double prior_std = 0.5;          ///< relative, of each; h2, h3 as if they were at least h1 / 20
  deposition::Border border = deposition::Border::kLose;
  int window_layers = 10;
  int max_evaluations = 60;  ///< of the objective, per layer and round
  /// M: a layer that is a layers old has the weight (1 - 1/M)^a, so that a drifting jet is followed; 0:
  /// nothing is forgotten. The prior keeps its own.
  double memory_layers = 0.0;
};
inline constexpr OptionTable kEstimatorOptions{
    Option{"window_layers", &EstimatorOptions::window_layers, "layers", within(1, 1000),
           "layers that are estimated anew each time; older ones as a summary"},
    Option{"prior_std", &EstimatorOptions::prior_std, "", above(0, 10),
           "relative standard deviation of what model.h1_mm..h3_mm are believed to be"},
    Option{"max_evaluations", &EstimatorOptions::max_evaluations, "", within(10, 10000),
           "of the estimator's objective, per layer and round"},
    Option{"memory_layers", &EstimatorOptions::memory_layers, "layers", zero_or(2, 1e6),
           "forgetting: a layer so many layers old counts 1 - 1/M to that power, about 1/e; 0 = nothing is "
           "forgotten"},
};

struct HeightFilterOptions {
  deposition::DropletModel model;
  deposition::Border border = deposition::Border::kLose;
  double droplet_scatter = 0.06;  ///< rho
};
inline constexpr Option kDropletScatter{
    "droplet_scatter", &HeightFilterOptions::droplet_scatter, "", within(0, 1),
    "kalman: relative standard deviation of a droplet; with adapt_model what droplet_estimator has learned "
    "takes its place"};

}  // namespace firn::droplet
