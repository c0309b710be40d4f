// The last layers of a part, printed over all of it at once.
#pragma once

#include "core/control/mpc/mpc.h"

namespace firn::control {

/// MPC in two stages. At the rim of a part ink runs off, so that the rim stays behind; MPC alone finishes the inside and
/// then raises the rim droplet by droplet, each of which lands on the edge of a wall and adds anything from nothing to 5 um.
/// In a full layer the same droplets, held by their neighbours, add nearly the same everywhere. So the part is first printed
/// to K layers below its target, until nothing betters that,
///   h_A(c) = max(0, h_d(c) - K l_c),   l_c = h1 + 4 h2 + 4 h3 by the newest model of the cell's place,
/// and only then to h_d: in about K layers that cover it whole. Keeps no state between decisions: a layer that betters h_A is
/// printed, whenever it is found.
class FinishTogether final : public LayerController {
 public:
  /// K = options.mpc.finish_layers. @throws std::invalid_argument: K not finite or below 0, or what Mpc throws.
  FinishTogether(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override;
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override;
  void use_threads(const ParallelFor& parallel) override;

  HeightMap first_target() const;  ///< h_A

 private:
  Setup setup_;
  ControlOptions options_;
  double layer_mm_;  // of the model at first
  ParallelFor parallel_ = serially;
  Mpc last_;
};

}  // namespace firn::control
