// ValveDriveConfig holds the settings of a micro-solenoid valve's controller, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

struct ValveDriveConfig {
  double pulse_us = 1250.0;
  double guard_us = 100.0;     ///< minimum time between two pulses
  double poll_firing_s = 0.5;  ///< also the sign of life that keeps the firmware's 2 s from running out
  double latency_s = 0.01;     ///< from a pulse's tick to liquid at the surface
};
inline constexpr OptionTable kValveDriveConfig{
    Option{"pulse_us", &ValveDriveConfig::pulse_us, "us", within(500, 65535), "width of a pulse"},
    Option{"guard_us", &ValveDriveConfig::guard_us, "us", within(0, 65535), "least time between two pulses"},
    Option{"poll_firing_s", &ValveDriveConfig::poll_firing_s, "s", above(0, 2),
           "between status questions while it fires"},
    Option{
        "latency_s", &ValveDriveConfig::latency_s, "s", within(-1, 1),
        "from a pulse's tick to liquid on the surface, less what the arm lags behind its commanded path, as "
        "the lab believes; firn calibrate measures it"},
};

}  // namespace firn::drivers
