// OpenLoop computes layers without feedback: the baseline of the papers.
#pragma once

#include "core/control/controller.h"
#include "core/control/prediction.h"

namespace firn::control {

/// Layer k (1-based) prints one droplet on every cell of the mask whose number of layers is at least k. A
/// cell's number of layers is target / (h1 + 4 h2 + 4 h3), rounded to the nearest (a full layer far from any
/// edge adds that height), or OpenLoopOptions::layers for all. Heights are only read to report the objective.
/// Two inks: layer k's materials are those at k - 1 layers of that fixed height [Lu 2015, V-A, Fig. 13].
/// Keeps no state.
class OpenLoop final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument: layers below 0.
  OpenLoop(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  int layers() const { return layers_; }  ///< of the whole part

 private:
  Setup setup_;
  OffsetMap inset_;  // of ControlOptions::rim_inset
  Predictor predict_;
  Grid<std::int32_t> layers_of_cell_;
  int layers_ = 0;
};

}  // namespace firn::control
