// SensorOptions, NozzleFaults and StageFaults hold the faults of real instruments that any world of the
// ink-jet lab can have. All are off by default.
#pragma once

#include "core/options/option.h"

namespace firn::plant {

/// Properties and faults of the profile sensor (plant/inkjet/sensor.h), beside its white noise and its
/// drop-outs.
struct SensorOptions {
  double offset_noise_mm = 0.0;
  double tilt = 0.0;
  double scale = 1.0;
  double spot_x_mm = 0.02;
  double spot_y_mm = 0.05;
  double wave_mm = 0.0;
  double wave_length_mm = 2.0;
  double ghost_share = 0.0;
  double ghost_reach_mm = 0.3;
  double ghost_step_mm = 0.02;
  bool operator==(const SensorOptions&) const = default;
};
inline constexpr OptionTable kSensorOptions{
    Option{"offset_noise_mm", &SensorOptions::offset_noise_mm, "mm", within(0, 1),
           "standard deviation of a whole profile's height [U]"},
    Option{"tilt", &SensorOptions::tilt, "", within(-0.1, 0.1),
           "error of height for each mm along the profile, from the field's middle: a head that hangs at an "
           "angle [U]"},
    Option{"scale", &SensorOptions::scale, "", within(0.5, 2),
           "reading by true height: linearity of a head, 0.1 % of its range in vendors' sheets [U]"},
    Option{"spot_x_mm", &SensorOptions::spot_x_mm, "mm", within(0, 1),
           "blur: width of the spot along the profile, over which heights are averaged"},
    Option{"spot_y_mm", &SensorOptions::spot_y_mm, "mm", within(0, 1), "the same across it"},
    Option{"wave_mm", &SensorOptions::wave_mm, "mm", within(0, 1),
           "correlated noise: standard deviation of a first-order autoregression along each profile [U]"},
    Option{"wave_length_mm", &SensorOptions::wave_length_mm, "mm", above(0, 1000),
           "distance over which that noise falls to 1/e of its correlation [U]"},
    Option{"ghost_share", &SensorOptions::ghost_share, "", within(0, 1),
           "edge ghosts: a reading beside a higher edge is drawn up by this share of the step [Curless and "
           "Levoy 1995: "
           "triangulation is biased where the spot straddles a step]; the share is [U]"},
    Option{"ghost_reach_mm", &SensorOptions::ghost_reach_mm, "mm", above(0, 10),
           "distance from an edge within which it shows a ghost [U]"},
    Option{"ghost_step_mm", &SensorOptions::ghost_step_mm, "mm", above(0, 10),
           "least height of an edge that shows a ghost [U]"},
};

/// Faults of the nozzle, in every world of the ink-jet lab.
struct NozzleFaults {
  double deflect_x_mm = 0.0, deflect_y_mm = 0.0;
  int deflect_layer = 1;
  int dead_layer = 0;
  double weak_idle_s = 0.0;
  int weak_droplets = 3;
  double drip_idle_s = 0.0;
  bool operator==(const NozzleFaults&) const = default;
  bool any() const {
    return deflect_x_mm != 0.0 || deflect_y_mm != 0.0 || dead_layer > 0 || weak_idle_s > 0.0 ||
           drip_idle_s > 0.0;
  }
};
inline constexpr OptionTable kNozzleFaults{
    Option{"deflect_x_mm", &NozzleFaults::deflect_x_mm, "mm", within(-5, 5),
           "by which droplets land beside their place once the wetted nozzle deflects them [Zhou and Ma, "
           "NIP27 (2011) 286: "
           "wetting decides straightness]; the distance is [U]"},
    Option{"deflect_y_mm", &NozzleFaults::deflect_y_mm, "mm", within(-5, 5), "the same along y"},
    Option{"deflect_layer", &NozzleFaults::deflect_layer, "layers", within(1, 1e6),
           "first layer of the deflection"},
    Option{"dead_layer", &NozzleFaults::dead_layer, "layers", within(0, 1e6),
           "from this layer on no droplet leaves the nozzle; 0 = never"},
    Option{"weak_idle_s", &NozzleFaults::weak_idle_s, "s", within(0, 1e5),
           "after a rest of more than this the first droplets are missing: the latency of a nozzle, about 30 "
           "s of thermal "
           "heads [Xerox Disclosure J. 1998, IPCOM000027645D]; 0 = never"},
    Option{"weak_droplets", &NozzleFaults::weak_droplets, "droplets", within(1, 1e6),
           "droplets that are missing then [U]"},
    Option{"drip_idle_s", &NozzleFaults::drip_idle_s, "s", within(0, 1e5),
           "after a rest of more than this the first droplet is two: ink has gathered at the nozzle; 0 = "
           "never [U]"},
};

/// Errors of the stage's place while it prints, in every world of the ink-jet lab.
struct StageFaults {
  double backlash_mm = 0.0;
  double stretch_x = 0.0, stretch_y = 0.0;
  double cyclic_mm = 0.0;
  double cyclic_period_mm = 5.0;
  bool operator==(const StageFaults&) const = default;
  bool any() const { return backlash_mm != 0.0 || stretch_x != 0.0 || stretch_y != 0.0 || cyclic_mm != 0.0; }
};
inline constexpr OptionTable kStageFaults{
    Option{"backlash_mm", &StageFaults::backlash_mm, "mm", within(0, 1),
           "lost motion of x: the carriage is behind its encoder by half of this in the direction of motion "
           "[U]"},
    Option{
        "stretch_x", &StageFaults::stretch_x, "", within(-0.05, 0.05),
        "error map: error of x for each mm from the grid's origin, 12e-6 for each kelvin of a steel scale"},
    Option{"stretch_y", &StageFaults::stretch_y, "", within(-0.05, 0.05), "the same of y"},
    Option{"cyclic_mm", &StageFaults::cyclic_mm, "mm", within(0, 1),
           "error map: amplitude of the error of x over each turn of the screw [U]"},
    Option{"cyclic_period_mm", &StageFaults::cyclic_period_mm, "mm", above(0, 1000), "lead of the screw [U]"},
};

}  // namespace firn::plant
