// The world of the aerosol lab: stage with shutter and profiler over lines of ink, mass-flow controllers that
// feed the nozzle, a heated platen.
#pragma once

#include "plant/aerosol/source.h"
#include "plant/config/world_config.h"
#include "plant/twins/gas.h"

namespace firn::plant {

/// Its part of WorldConfig.
struct AerosolWorldConfig {
  AerosolParams nozzle;
  GasParams gas;
  double atomizer_sccm = 20.0, sheath_sccm = 40.0;  ///< at which the nozzle's flow and focusing are as above
};

extern const WorldKind kAerosolWorld;

}  // namespace firn::plant
