// strobe_scene renders the picture of the ink-jet lab's camera at one exposure: nozzle, dirt, and the jet's
// droplet if it jets.
#pragma once

#include "plant/config/world_config.h"
#include "plant/inkjet/strobe_picture.h"
#include "plant/twins/camera.h"

namespace firn::plant {

/// Sets the optics that the configuration has for any camera. @param dirt_key of the random specks
void set_optics(const WorldConfig& config, std::uint32_t dirt_key, Optics& optics);

/// The gain scales the light; the flash, not the exposure, gives its amount.
/// @param speed_m_s of the droplets as they leave the nozzle; 0 = there are none
TakenPicture strobe_scene(const WorldConfig& config, double speed_m_s, const Exposure& exposure);

/// The jet of the configuration, with this speed. Its diameter is that of DropletParams::volume_mm3.
StrobeJet strobe_jet(const WorldConfig& config, double speed_m_s);

/// Time of a droplet's fall through the nozzle's gap, slowed by the air; 0 where it is not simulated.
double fall_s(const WorldConfig& config, double speed_m_s);

}  // namespace firn::plant
