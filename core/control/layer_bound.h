// with_layer_bound adds the bound on layers and the target's offset to a scheme that is not in the table of
// schemes.
#pragma once

#include <memory>

#include "core/control/controller.h"

namespace firn::control {

/// Returns the scheme with what those of the table have: it stops for the operator at
/// ControlOptions::max_layers, and aims ControlOptions::target_offset_mm above the target. @throws
/// std::invalid_argument: one of the two out of its range
std::unique_ptr<LayerController> with_layer_bound(std::unique_ptr<LayerController> scheme, const Setup& setup,
                                                  const ControlOptions& options);

}  // namespace firn::control
