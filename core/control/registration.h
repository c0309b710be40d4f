// RegistrationPrint computes layers of marks of both nozzles side by side, from which the offset of the
// second is measured (estimators/registration/nozzle_offset.h).
#pragma once

#include <vector>

#include "core/control/controller.h"
#include "core/control/prediction.h"

namespace firn::control {

/// A mark: droplets on one cell, by one nozzle.
struct Mark {
  int i = 0, j = 0;
  Material material = Material::kA;
};

/// Marks `spacing_cells` apart, at least half of that from the grid's edge, where the mask has a cell; the
/// nozzles alternate like a chessboard's squares, so that a tilt or bend of the map moves both alike.
std::vector<Mark> registration_marks(const Mask& mask, int spacing_cells);

/// Prints RegistrationOptions::layers droplets on each mark, one per layer, and ends. Heights decide nothing.
class RegistrationPrint final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument naming the option: layers below 1, spacing_cells below 4; room for fewer
  /// than three marks of each nozzle.
  RegistrationPrint(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;

 private:
  Setup setup_;
  int layers_;
  Predictor predict_;
  DropletPattern drops_;
  MaterialMap materials_;
};

}  // namespace firn::control
