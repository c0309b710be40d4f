// with_layer_bound bounds the number of layers of a scheme that is not in the table of schemes.
#pragma once

#include <memory>

#include "core/control/controller.h"

namespace firn::control {

/// Returns the scheme with the bound that those of the table have: it stops for the operator at
/// ControlOptions::max_layers. @throws std::invalid_argument: a max_layers out of its range
std::unique_ptr<LayerController> with_layer_bound(std::unique_ptr<LayerController> scheme, const Setup& setup,
                                                  const ControlOptions& options);

}  // namespace firn::control
