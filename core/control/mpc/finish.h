// The last layers of a part, printed over all of it at once.
#pragma once

#include "core/control/mpc/mpc.h"

namespace firn::control {

/// MPC in two stages. At the rim of a part ink runs off, so that the rim stays behind; MPC alone finishes the
/// inside and then raises the rim droplet by droplet, each of which lands on the edge of a wall and adds
/// anything from nothing to 5 um. In a full layer the same droplets, held by their neighbours, add nearly the
/// same everywhere. So the part is first printed to K layers below its target, until nothing betters that,
///   h_A(c) = max(0, h_d(c) - K l_c),   l_c = h1 + 4 h2 + 4 h3 of the first model; on Setup::rim times
///   model_b's share of it,
/// and only then to h_d. A jet's flow wanders by a part w from layer to layer, so that what every further
/// layer of a plan reaches is off by w l more: of the best plans of n = 1 .. N layers the one is taken with
/// the least
///   J_n^2 + n (w l)^2,   J_n: objective of MPC with horizon n, w = kWander, l of the newest model.
/// Otherwise layer after layer is put off for one that prepares it. Keeps no state between decisions: a layer
/// that betters h_A is printed whenever it is found, and h_A does not move with the model, so that the last
/// layers are not held up again.
///
/// With L = rim_lead_layers > 0 the part rises together with its rim, and is finished from a flow that is
/// known:
///  - while the rim is behind the rest by more than L layers, d_r - d_i > L l, the rest waits: the target is
///      h_B(c) = max(0, h_A(c) - d_i)   instead of h_A;   d_r, d_i >= 0: mean of h_A - H over the rim and
///      over the rest;
///  - in the first stage too the best of n = 1 .. N is taken, and a layer ends it that lowers J^2 by less
///  than kWorth (w l)^2;
///  - in the last stage n <= kLastHorizon = 2: while more than two layers are missing the next one is full.
///  It tells the flow, and
///    the partial layer and the last full one are planned with what is known best. K = 3 leaves room for one;
///  - when the rest is within half a layer of h_d, droplets are alone at the rim and are taken to add
///  kLoneShare of a droplet.
/// h_B <= h_A: what fills cells up to h_B fills them up to h_A, and every print ends as without it (guard.h).
/// No rim: h_B = h_A.
class FinishTogether final : public LayerController {
 public:
  static constexpr double kWander = 0.02;  ///< w, as DropletFactors takes it
  static constexpr double kWorth = 15.0;
  static constexpr double kLoneShare = 0.5;
  static constexpr int kLastHorizon = 2;

  /// K = options.mpc.finish_layers, L = rim_lead_layers. @throws std::invalid_argument: K or L not finite or
  /// below 0, or what Mpc throws.
  FinishTogether(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override { setup_.model = model; }
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override;
  void use_threads(const ParallelFor& parallel) override { parallel_ = parallel; }

  HeightMap first_target() const;                        ///< h_A
  HeightMap held_target(const HeightMap& height) const;  ///< h_B on this surface, h_A where nothing waits

 private:
  bool together() const { return options_.mpc.rim_lead_layers > 0.0; }
  bool worth_its_time(const Decision& d) const;
  bool only_rim(const HeightMap& height) const;
  Decision plan(const Setup& setup, const ControlOptions& options, const Measurement& m) const;
  Decision best_of_horizons(const Setup& setup, const Measurement& m, int most) const;

  Setup setup_;
  ControlOptions options_;
  double layer_mm_;  // of the model at first
  ParallelFor parallel_ = serially;
};

}  // namespace firn::control
