// Threshold computes layers by threshold feedback after Cohen and Lipson, the closed-loop baseline of Lu's
// paper.
#pragma once

#include "core/control/controller.h"
#include "core/control/prediction.h"

namespace firn::control {

/// D. L. Cohen and H. Lipson, "Geometric feedback control of discrete-deposition SFF systems", Rapid
/// Prototyping J. 16 (2010) 377-393, as cited in [Lu 2015, section I]: model and measurement are compared,
/// "locations with errors higher than threshold are tagged as future deposition candidates", so that
/// "corrective action is taken only if the height has sufficiently large error"; neighbouring droplets do not
/// interact, and each falls on flat ground. On the grid:
///   after layer k, cell c gets one droplet when  r_{k+1} - H_c > threshold,   r_k = min(k dh, target_c),
/// dh the nominal layer. The footprint over which their error is an RMS is here the one cell of the droplet.
/// The default threshold, dh / 2, is where one droplet of height dh begins to lessen |r - H|. The print ends
/// when the reference has reached the target and no cell is tagged. Keeps no state.
class Threshold final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument: threshold_mm or layer_height_mm below 0 or not finite.
  Threshold(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_options(const ControlOptions& options) override;
  double threshold_mm() const { return threshold_mm_; }

 private:
  Setup setup_;
  double dh_mm_;
  double threshold_mm_;
  OffsetMap inset_;  // of ControlOptions::rim_inset
  Predictor predict_;
};

}  // namespace firn::control
