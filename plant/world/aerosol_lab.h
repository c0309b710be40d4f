// The world of the aerosol lab: stage with shutter and profiler over lines of ink.
#pragma once

#include "plant/aerosol/source.h"
#include "plant/config/world_config.h"

namespace firn::plant {

extern const WorldKind kAerosolWorld;

}  // namespace firn::plant
