// LayerController computes the droplets of the next layer from the measured surface: the interface of every
// feedback scheme. A new scheme is one class and one row in the table of schemes.cpp
// (docs/write-a-controller.md).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/control/options.h"
#include "core/deposition/offset_change.h"
#include "core/deposition/two_materials.h"
#include "core/grid/decision.h"
#include "core/grid/geometry.h"
#include "core/grid/grid.h"
#include "core/grid/parallel.h"

namespace firn::control {

/// Holds the grid, the target, the droplet models and the seed that a scheme is built from.
struct Setup {
  GridSpec grid;
  HeightMap target;                ///< h_d [mm], finite and not negative on the mask
  Mask mask;                       ///< only these cells get droplets and count in the objective
  deposition::DropletModel model;  ///< height change of one droplet
  deposition::Border border = deposition::Border::kLose;
  std::uint64_t seed = 1;  ///< of the run; draws are keyed (seed, purpose, layer, attempt, n)
  /// M [Lu 2015, IV-B]: with it a block of two inks is printed, `model` being the object's and `model_b` the
  /// support's; null: one ink.
  std::shared_ptr<const Geometry> geometry = nullptr;
  deposition::DropletModel model_b = {};  ///< g1, g2, g3
  /// Height above a cell's surface at which its ink is chosen. 0 as in the paper. Half a layer is the middle
  /// of the next droplet, so that interfaces do not end half a layer too high.
  double judge_above_mm = 0.0;
  /// Cells whose droplets follow model_b although there is one ink only: ink runs off the part at its rim.
  /// Only MPC uses them. Empty: no such cells. Must be empty with a geometry.
  Mask rim = {};
  /// Places of droplets inside their cells with the height change of each, of `model` and of `model_b`. By
  /// default the table has the centre alone.
  deposition::OffsetModel offsets = {}, offsets_b = {};

  const deposition::DropletModel& model_of(Material m) const { return m == Material::kB ? model_b : model; }
};
/// @throws std::invalid_argument naming the fault: grid, sizes, an empty mask, a target not finite or
/// negative, a geometry of another grid, a judge_above_mm not finite or negative.
void check(const Setup& setup);

/// The surface after `layer` layers.
struct Measurement {
  const HeightMap& height;    ///< [mm]; finite on the mask. NaN outside it counts as 0 mm, the bare substrate
  int layer = 0;              ///< layers deposited so far; the decision is for layer + 1
  int attempt = 0;            ///< re-measurement number of this layer
  double noise_std_mm = 0.0;  ///< of one cell; 0 = unknown
  /// The surface blended with the one that the executed droplets predict, finite on the mask, and the
  /// standard deviation of one of its cells. Null: there is none. For a scheme that chooses between the two;
  /// to all others the blended surface is handed in as `height`.
  const HeightMap* estimate = nullptr;
  double estimate_std_mm = 0.0;
};

struct Decision {
  using Kind = PlanDecision;
  Kind kind = Kind::kStop;
  DropletPattern drops;  ///< on the setup's grid; all zero unless kPrint; zero outside the mask
  /// Predicted objective [Lu 2015, Eq. (8)] of `drops` and of no droplet. Open loop and SMF: the mean |error|
  /// (alpha = 1) by the height-change model.
  double objective_mm = 0.0, objective_none_mm = 0.0;
  std::int64_t iterations = 0;  ///< single-droplet changes evaluated by a search
  MaterialMap materials;        ///< ink of each cell of the mask in this layer; no cells with one ink
  OffsetMap
      offsets;  ///< place of each cell's droplets, of Setup::offsets.table; without cells: all in the centres
  std::string reason;       ///< one sentence
  std::string notice = {};  ///< a sentence that the operator is told beside the plan; empty: nothing
};

/// A feedback scheme. Its state is a pure function of the measurements handed in so far (it is replayed): no
/// clock, no unkeyed randomness. A second call for the same layer (attempt + 1) replaces the first. Every
/// function is pure virtual, so that a wrapper that does not forward one does not compile
/// (core/control/forwarding_controller.h).
class LayerController {
 public:
  virtual ~LayerController() = default;
  /// @throws std::invalid_argument when check(measurement, setup) does.
  virtual Decision decide(const Measurement& measurement) = 0;
  /// Sets the estimate of a droplet's height change (updated while printing). A scheme that does not plan
  /// with the height-change model has no use for it. @throws std::invalid_argument when
  /// deposition::check(model) does.
  virtual void use_model(const deposition::DropletModel& model) = 0;
  /// Sets the threads for parallel work. The result has the same bytes for any number of threads.
  virtual void use_threads(const ParallelFor& parallel) = 0;
  /// The same for the droplets of Setup::rim, `inside` for all others.
  virtual void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) = 0;
  /// Takes the options that may change between layers (Change::kBetweenLayers); later decisions use them.
  /// @throws std::invalid_argument naming the option, which then is as before
  virtual void use_options(const ControlOptions& options) = 0;
};

/// Base of the schemes: ignores what a scheme has no use for.
class LayerControllerBase : public LayerController {
 public:
  void use_model(const deposition::DropletModel& /*model*/) override {}
  void use_threads(const ParallelFor& /*parallel*/) override {}
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& /*rim*/) override {
    use_model(inside);
  }
  void use_options(const ControlOptions& /*options*/) override {}
};

/// @throws std::invalid_argument: another grid, a layer or attempt below 0, a height on the mask that is not
/// finite (names the cell).
void check(const Measurement& measurement, const Setup& setup);

/// The measured heights with 0 mm where nothing was measured outside the mask.
HeightMap known_heights(const Measurement& measurement);

/// I_A and I_B [Lu 2015, IV-B]: each cell of the mask by whether its height (and judge_above_mm) lies in M,
/// `rise_mm` higher for a later layer. Without cells when the setup has one ink.
MaterialMap materials_at(const Setup& setup, const HeightMap& height, double rise_mm = 0.0);
/// The same for a layer of fixed height: all cells at height_mm.
MaterialMap materials_at(const Setup& setup, double height_mm);

/// A scheme by name.
struct Scheme {
  std::string_view name;
  std::string_view meaning;
  std::unique_ptr<LayerController> (*make)(const Setup&, const ControlOptions&);
  std::span<const ExtraOption> extra = {};  ///< parameters of its own, [control.extra]
};
std::span<const Scheme> schemes();

/// @throws std::invalid_argument: unknown options.scheme (lists the known ones), a bad setup or option.
std::unique_ptr<LayerController> make_controller(const Setup& setup, const ControlOptions& options);

}  // namespace firn::control
