// SomeJet is a jet of the kind that its settings name.
#pragma once

#include <memory>

#include "drivers/jet/jet_driver.h"
#include "drivers/jet/jet_interface.h"
#include "drivers/link/some_driver.h"

namespace firn::drivers {

using SomeJet = Some<JetInterface>;

/// Returns a jet of the kind config.kind. @throws std::invalid_argument naming the setting and its range
std::unique_ptr<JetDriver> make_jet(const JetOptions& config);

}  // namespace firn::drivers
