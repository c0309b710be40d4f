// Predictor computes the heights after a layer by the height-change model, and the objective.
#pragma once

#include "core/control/controller.h"
#include "core/deposition/height_change.h"

namespace firn::control {

/// Objective of Eq. (8) [Lu 2015] over the mask: alpha avg|h_d - H| + (1 - alpha) std(H - h_d), std about the
/// mean with divisor n, two passes in index order. h_d is a matrix (errata): for the flat h_d of (8) the
/// second term is the printed std(H); for any other, the printed form would punish the part's own shape.
double objective_mm(const HeightMap& height, const HeightMap& target, const Mask& mask, double alpha);

/// True when `decision` improves on printing nothing by more than `gate` * noise_std_mm for each of its
/// droplets (an objective is a mean over `part_cells` cells, so one droplet that mends h mm is worth h /
/// part_cells). Squares: when it lessens the sum of squares by more than `gate` * noise_std_mm^2 for each.
bool beats_noise(const Decision& decision, std::int64_t part_cells, double noise_std_mm, double gate,
                 ErrorKind error = ErrorKind::kAbsolute);

/// Turns a decision into the end of the print.
void end_print(Decision& decision, std::string reason);

/// Forward prediction on a setup's grid.
class Predictor {
 public:
  explicit Predictor(const Setup& setup);
  /// All passes of one layer. @param materials of the droplets; no cells: one ink
  /// @param offsets their places; no cells: all in the centres, by the height-change model alone
  HeightMap after(const HeightMap& height, const DropletPattern& drops, const MaterialMap& materials = {},
                  const OffsetMap& offsets = {});
  /// Fills a decision's two objectives for its drops, materials and offsets.
  void score(Decision& decision, const HeightMap& height, double alpha);

 private:
  HeightMap target_;
  Mask mask_;
  deposition::HeightChange<1> model_;
  deposition::TwoMaterialChange two_inks_;
  deposition::OffsetChange offsets_;
};

}  // namespace firn::control
