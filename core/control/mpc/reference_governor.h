// ReferenceGovernor computes the layers of a part by MPC for a target that it lowers at first, so that the
// last layers are printed over all of the part at once.
#pragma once

#include <array>
#include <optional>

#include "core/control/mpc/edge_reference.h"
#include "core/control/mpc/mpc.h"
#include "core/control/stall_detector.h"

namespace firn::control {

/// A reference governor around MPC, in two stages. Ink runs off at the rim of a part, so that the rim lags
/// behind. MPC alone finishes the inside first. It then raises the rim droplet by droplet, and each droplet
/// lands on the edge of a wall and adds between nothing and 5 um. In a full layer the same droplets are held
/// by their neighbours and add nearly the same height everywhere. So the part is first printed to K layers
/// below its target, until no layer improves the objective for
///   h_A(c) = max(0, h_d(c) - K l_c),   l_c = h1 + 4 h2 + 4 h3 of the first model; on Setup::rim times
///                                      model_b's share of it,
/// and only then to h_d. The flow of a jet varies by a part w from layer to layer, so that the height after
/// every further layer of a plan has an additional error of w l. Of the optimal plans of n = 1 .. N layers
/// the one with the least
///   J_n^2 + n (w l)^2,   J_n: objective of MPC with horizon n, w = kProcessNoiseStd, l of the newest model,
/// is taken. Without this term the plan would postpone printing for ever. A layer that improves the objective
/// for h_A is printed in any case, and h_A does not change with the model, so that the last layers are not
/// delayed again.
///
/// A stage in which ControlOptions::stall_layers layers have bettered the part about the stage's own target
/// by no more than noise is over (StallDetector), and the next one begins; the print ends with the last
/// stage. While the inside waits, only cells of the rim count. This is all the state that is kept between
/// decisions.
///
/// With a rim lag bound L = rim_lead_layers > 0 the part rises together with its rim, and is finished at a
/// known flow:
///  - While the rim lags by more than L layers, d_r - d_i > L l, the target of the rest is lowered:
///      h_B(c) = max(0, h_A(c) - d_i)   instead of h_A.
///    d_r, d_i >= 0: mean of h_A - H over the rim and over the rest.
///  - The first stage too takes the best of n = 1 .. N, and ends at a layer that lowers J^2 by less than
///    kStopThreshold (w l)^2.
///  - The last stage has n <= kLastHorizon = 2: while more than two layers are missing the next one is full.
///    The flow is estimated from it, and the partial layer and the last full one are planned with this
///    estimate. K = 3 leaves room for one such layer.
///  - When the rest is within half a layer of h_d, only droplets at the rim remain. Each is assumed to add
///    kLoneShare of a droplet.
/// With rise_layers > 0 a stage comes before all others: the part rises layer by layer towards the references
/// of EdgeReference, each layer planned by itself, until all cells have h_A but for the lag of the edge.
///
/// h_B <= h_A: droplets that fill cells up to h_B also fill them up to h_A, so every print ends as without
/// the bound (guard.h). Without a rim h_B = h_A.
class ReferenceGovernor final : public LayerController {
 public:
  static constexpr double kProcessNoiseStd = 0.02;  ///< w, relative, as in DropletFactors
  static constexpr double kStopThreshold = 15.0;
  static constexpr double kLoneShare = 0.5;
  static constexpr int kLastHorizon = 2;

  /// K = options.mpc.finish_layers, L = rim_lead_layers. @throws std::invalid_argument: K or L not finite or
  /// below 0; options that Mpc refuses.
  ReferenceGovernor(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override { setup_.model = model; }
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override;
  void use_threads(const ParallelFor& parallel) override { parallel_ = parallel; }
  void use_options(const ControlOptions& options) override;

  HeightMap first_stage_target() const;                      ///< h_A
  HeightMap governed_target(const HeightMap& height) const;  ///< h_B; h_A within the lag bound

 private:
  bool together() const { return options_.mpc.rim_lead_layers > 0.0; }
  // Height that the rest is below h_A while it waits for the rim; 0: it does not wait.
  double waits_at_mm(const HeightMap& height, const HeightMap& first_stage_target) const;
  enum Stage : std::size_t { kRising, kWaiting, kLower, kLast, kStages };
  std::optional<Decision> rise(const Measurement& m);  // a layer of that stage; none: it is over
  // None: the stage is over.
  std::optional<Decision> decide_stage(Stage stage, HeightMap target, const Measurement& m);
  bool worth_its_time(const Decision& d) const;
  bool only_rim(const HeightMap& height) const;
  Decision plan(const Setup& setup, const ControlOptions& options, const Measurement& m) const;
  Decision best_of_horizons(const Setup& setup, const Measurement& m, int most) const;

  Setup setup_;
  ControlOptions options_;
  double layer_mm_;  // of the model at first
  Mask rim_;         // Setup::rim on the mask
  std::optional<EdgeReference> rise_;
  std::array<StallDetector, kStages> stalls_;
  ParallelFor parallel_ = serially;
};

}  // namespace firn::control
