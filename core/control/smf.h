// Smf computes layers by surface-mapping feedback, drop on demand [Barnett 2012, 5.1.2, 5.2.2, 5.2.3].
#pragma once

#include "core/control/controller.h"
#include "core/control/prediction.h"
#include "core/control/stall_detector.h"

namespace firn::control {

/// Matrix PID on the error surface in units of the layer interval dh:
///   e_k = (r_k - H_k) / dh,   U_k = Kp e_k + Ki* sum e_i + Kd* (e_k - e_{k-1})          (5.1), (5.2)
/// with r_k = min(k dh, target) per cell after k layers (the first measurement is k = 0; there the derivative
/// term is left out). The integral term is held within +-integral_limit and U within +-output_limit (5.2.2).
/// Drop on demand (5.2.3): the next layer shall add r_{k+1} - r_k + dh U_k, so a cell requires that height
/// divided by the height of a droplet. One droplet raises its own cell by h1 and the part that its neighbours
/// do not take, and every cell also receives a share of its neighbours' droplets. The height of a droplet per
/// cell is therefore h1 + 4 h2 + 4 h3, exact where all cells print the same; feedback corrects the rest.
/// Fractions become droplets by error diffusion (default): docs/algorithms/control.md compares it with
/// rounding and with carrying over. Two inks: a cell's ink is that of M at its measured height, and dh, r and
/// the error know no ink. Ends when r has reached the target everywhere and the next layer would not lower
/// the predicted mean |error|, or by no more than the noise gate. A wall of one cell, off which ink runs, may
/// lack many layers then, while the integral of the other cells still asks for droplets that make the layer
/// as a whole worse. So while a cell lacks more than kMostLack layers, the droplets of the short cells alone
/// are judged, until ControlOptions::stall_layers of such layers have bettered nothing. A second measurement
/// of a layer replaces the first in sum and difference. A layer below the last one seen starts anew.
class Smf final : public LayerControllerBase {
 public:
  static constexpr double kMostLack = 2.0;  ///< layers; cells of full layers end within one
  /// @throws std::invalid_argument naming the option: gains finite, kp above 0, the others not negative;
  /// limits above 0; layer_height_mm not negative; max_drops 1..16.
  Smf(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_options(const ControlOptions& options) override;

  const Grid<double>& output() const { return output_; }  ///< U of the last decision, 0 outside the mask
  double layer_height_mm() const { return dh_mm_; }

 private:
  struct Memory {
    int layer = -1;  // of the last measurement taken in; -1: none
    Grid<double> sum, error, carry;
  };
  double reference_mm(std::size_t cell, int layer) const;
  // Keeps a layer's droplets on cells that lack half a layer, if a cell lacks more than kMostLack. Returns
  // whether what is left betters the part.
  bool keep_short_cells(Decision& decision, const Measurement& m, const HeightMap& height);

  Setup setup_;
  SmfOptions options_;
  double dh_mm_, noise_gate_;
  int stall_layers_;
  std::int64_t part_cells_;
  OffsetMap inset_;  // of ControlOptions::rim_inset
  Predictor predict_;
  Memory before_, after_;  // the layer now being measured
  Grid<double> output_;
  StallDetector short_cells_;  ///< layers on short cells alone
};

}  // namespace firn::control
