// ValveDriveConfig holds the settings of a micro-solenoid valve's controller, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

/// Times that the firmware keeps or may take: ours, like its protocol.
struct ValveDialect {
  double arm_wait_s = 60.0;
  double poll_idle_s = 2.0;
  double finish_s = 0.5;
  int most_spits = 50;
};
inline constexpr OptionTable kValveDialect{
    Option{"arm_wait_s", &ValveDialect::arm_wait_s, "s", above(0, 3600),
           "after it the firmware gives up waiting for the trigger [P]"},
    Option{"poll_idle_s", &ValveDialect::poll_idle_s, "s", above(0, 60),
           "between status questions at rest [P]"},
    Option{"finish_s", &ValveDialect::finish_s, "s", above(0, 60),
           "a list that should be over may take so much longer before it is cut [P]"},
    Option{"most_spits", &ValveDialect::most_spits, "", within(1, 75),
           "pulses of one firn device spit, 20 ms apart: the firmware hears nothing meanwhile [P]"},
};

struct ValveDriveConfig {
  double pulse_us = 1250.0;
  double guard_us = 100.0;     ///< minimum time between two pulses
  double poll_firing_s = 0.5;  ///< also the sign of life that keeps the firmware's 2 s from running out
  double latency_s = 0.01;     ///< from a pulse's tick to liquid at the surface
  ValveDialect dialect = {};   ///< [devices.valve_a.dialect], [devices.valve_b.dialect]
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
