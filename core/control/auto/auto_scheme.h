// AutoScheme chooses among the shipped schemes by the signs of the printed layers, and says why.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/control/auto/lab_signs.h"
#include "core/control/controller.h"

namespace firn::control {

/// Scheme and settings that auto chooses among.
enum class AutoChoice : std::uint8_t {
  kTogether,   ///< strips over three layers by squares, the rim rising with the inside, on the estimate
  kStrips,     ///< strips over three layers by squares, on the map
  kSmf,        ///< surface-mapping feedback without its integral, on the map
  kThreshold,  ///< threshold feedback, which needs no model of a droplet's neighbours
};
inline constexpr std::array<std::string_view, 4> kAutoChoiceNames{
    "MPC of strips that rise together", "MPC of strips on the map", "SMF without integral", "threshold"};

struct AutoRule {
  AutoChoice choice = AutoChoice::kTogether;
  std::string why;  ///< half a sentence
};

/// The rule. Its thresholds were found on the tuning labs of experiments/worlds/inkjet.toml
/// (docs/algorithms/auto.md).
/// @param has_estimate whether measurements come with Measurement::estimate
/// @param now the choice of the layer before, which is left only where the evidence is clear
AutoRule auto_rule(const LabSigns& signs, double droplet_mm, bool has_estimate,
                   std::optional<AutoChoice> now);

/// Noise of a cell by the height of a droplet beyond which SMF prints better on the map than MPC.
inline constexpr double kAutoNoisy = 0.2, kAutoQuiet = 0.15;
/// Share of unlike rises that a model must explain to be used: below the first it is left, above the second
/// it is taken again.
inline constexpr double kAutoModelLeft = 0.0, kAutoModelTaken = 0.2;

/// Relative scatter of a droplet's height that the estimate and the plan of kTogether assume.
inline constexpr double kAutoScatter = 0.3;
/// ControlOptions of a choice: those of the experiment, but for the choice's own.
ControlOptions auto_options(AutoChoice choice, const ControlOptions& options,
                            const deposition::DropletModel& model);

/// Decides each layer by the scheme that auto_rule() names. A scheme that is chosen begins anew; one that was
/// left is forgotten. The state is a function of the measurements alone: a layer that is measured again is
/// decided as if the first time had not been.
class AutoScheme final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument: an option that a choice refuses; places of droplets inside their cells
  AutoScheme(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override;
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override;
  void use_threads(const ParallelFor& parallel) override;
  void use_options(const ControlOptions& options) override;

 private:
  struct State {
    explicit State(double droplet_mm) : signs(droplet_mm) {}
    int layer = -1;  ///< of the last measurement taken in; -1: none
    LabSigns signs;
    HeightMap height;      ///< after it, as measured
    DropletPattern drops;  ///< decided from it
    MaterialMap materials;
    std::optional<AutoChoice> choice;
    bool told = false;  ///< of what the layers tell of the models
    std::shared_ptr<LayerController> scheme;
  };
  std::shared_ptr<LayerController> made(AutoChoice choice) const;

  Setup setup_;
  ControlOptions options_;
  double droplet_mm_;
  ParallelFor parallel_ = serially;
  std::optional<deposition::DropletModel> inside_, rim_;  ///< newest, of use_models
  State before_, after_;                                  ///< the layer now being measured
};

}  // namespace firn::control
