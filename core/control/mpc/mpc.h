// Mpc computes layer patterns by model predictive control [Lu 2015, Eq. (8)].
#pragma once

#include <optional>

#include "core/control/controller.h"
#include "core/control/mpc/greedy.h"
#include "core/control/mpc/objective.h"

namespace firn::control {

/// Minimises alpha avg|h_d - H| + (1 - alpha) std(H - h_d) after N layers over 0..max_drops droplets per cell
/// and layer (Lu: 0 or 1), by greedy search from up to two first guesses, and prints the first layer of the
/// best plan. method kStripDp: the first layer of the guess is first made optimal in every strip of
/// strip_rows rows by dynamic programming (strip_dp.h), which is all there is to do for alpha = 1 and N = 1.
/// The mean and deviation run over the mask; cells outside it take their neighbours' flow in the model but
/// get no droplets. Empty layers of a plan go to its end (the heights after N layers stay the same). Two
/// inks: the layer's materials are those of M at the measured heights, later layers of the horizon are
/// evaluated whole layers of the object's ink higher. Guard (errata on (8)): std has infinite slope on a flat
/// surface, so that both all and nothing can be traps; a plan is printed only when it improves on printing
/// nothing over the same horizon by more than min_improvement_mm and the noise gate, else the print ends.
/// On a part of more than mpc::kTiledCells cells one layer is searched tile by tile (mpc/tiled_greedy.h).
/// With places of droplets inside their cells (Setup::offsets) counts and places are decided together, one
/// layer at a time (mpc/placed_search.h);
/// kCertified: each cell at the outline chooses among its centre and the place of ControlOptions::rim_inset,
/// and the layer comes with a bound. Keeps no state between decisions: draws are keyed (seed, kGreedySearch,
/// layer, attempt).
class Mpc final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument naming the option: horizon 1..8, subset and max_evaluations 1 or more,
  /// max_drops 1..8, strip_rows 1..6, alpha in (0, 1] with ascending layers from 1, min_improvement_mm not
  /// negative, at least one first guess.
  Mpc(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override;
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override;
  void use_threads(const ParallelFor& parallel) override { parallel_ = parallel; }
  void use_options(const ControlOptions& options) override;
  double alpha_at(int layer) const;  ///< layer 1-based

 private:
  std::vector<DropletPattern> first_guess(const HeightMap& height, const MaterialMap& materials,
                                          bool dithered) const;
  std::vector<MaterialMap> materials_of(const HeightMap& height) const;  // per layer of the horizon
  struct Found {
    std::int64_t evaluations = 0;
    bool optimal = false;
    std::string reached = {};  // of kCertified
  };
  // One layer of at most one droplet per cell by |error|, as LayerProblem requires.
  bool one_layer() const {
    return options_.horizon == 1 && options_.max_drops == 1 && options_.error == ErrorKind::kAbsolute;
  }
  // Betters the plan that objective_ is to hold, from a first guess.
  Found search(std::vector<DropletPattern> guess, const HeightMap& height,
               std::span<const MaterialMap> materials, double alpha, std::int64_t evaluations,
               RandomStream& random);

  // The best of both first guesses without HorizonObjective (mpc/one_layer.h). @pre one_layer(), strips, one
  // ink, alpha 1
  Decision decide_lean(const Measurement& m, const HeightMap& height) const;
  // By tiles of the grid (mpc/tiled_greedy.h). @pre one_layer(), greedy, one ink, alpha 1
  Decision decide_tiled(const Measurement& m, const HeightMap& height) const;
  std::int64_t part_cells() const;
  // With places: mpc/placed_search.h. @pre one_layer(), alpha 1
  Decision decide_placed(const Measurement& m, const HeightMap& height);
  bool placed() const { return setup_.offsets.table.size() > 1; }
  mpc::HorizonObjective& objective();  // built when first asked for: it takes 250 bytes per cell
  bool strips() const {
    return options_.method == MpcMethod::kStripDp || options_.method == MpcMethod::kCertified;
  }

  Setup setup_;
  MpcOptions options_;
  double noise_gate_, rim_inset_;
  ParallelFor parallel_ = serially;
  std::optional<mpc::HorizonObjective> objective_;
};

}  // namespace firn::control
