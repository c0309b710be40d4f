// From an experiment's configuration to a world.
#pragma once

#include "config/experiment.h"
#include "plant/config/world_config.h"

namespace firn::plant {

/// Nature's parameters come from [plant]; the instruments' from the lab's sections. What the controllers
/// believe
/// ([model]) does not reach nature.
WorldConfig world_config(const Experiment& experiment);

}  // namespace firn::plant
