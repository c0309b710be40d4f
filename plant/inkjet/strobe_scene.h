// strobe_scene renders what the ink-jet lab's camera sees at one exposure: nozzle, dirt, and the jet's
// droplet if it jets.
#pragma once

#include "plant/config/world_config.h"
#include "plant/inkjet/strobe_picture.h"
#include "plant/twins/camera.h"

namespace firn::plant {

/// The gain scales the light; the flash, not the exposure, gives its amount.
TakenPicture strobe_scene(const WorldConfig& config, bool droplet, const Exposure& exposure);

/// The jet of the configuration. Its diameter is that of DropletParams::volume_mm3.
StrobeJet strobe_jet(const WorldConfig& config);

/// Time of the droplet's fall through the nozzle's gap, slowed by the air; 0 where it is not simulated.
double fall_s(const WorldConfig& config);

}  // namespace firn::plant
