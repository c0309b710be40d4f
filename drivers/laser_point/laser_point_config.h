// LaserPointConfig holds the settings of the point laser, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

struct LaserPointConfig {
  double rate_hz = 100.0;    ///< of stored samples
  double latency_s = 0.03;   ///< from the start of the motion to the first stored sample
  double offset_x_mm = 0.0;  ///< of the spot, beyond the machine's tool_laser
  double offset_y_mm = 0.0;
  double offset_z_mm = 0.0;      ///< added to every height
  double bias_limit_mm = 0.15;   ///< calibrated uncertainty of heights; 0: the bare table is not checked
  double offset_limit_mm = 0.5;  ///< and of places; 0: the first interval's outline is not checked
  int program_part = 0, program_scaffold = 1;  ///< the controller's stored settings
  int surface_part = 1, surface_scaffold = 0;  ///< its kinds of surfaces
  int sampling_us = 200;                       ///< one of lkg::kSampling_us
  int averaging = 2;                           ///< 4^n readings; they blur the path by their time
  double poll_idle_s = 5.0;
};
inline constexpr OptionTable kLaserPointConfig{
    Option{"rate_hz", &LaserPointConfig::rate_hz, "Hz", within(1, 1000), "of stored samples"},
    Option{"latency_s", &LaserPointConfig::latency_s, "s", within(-1, 1),
           "from the start of the commanded path to the first sample, less what the arm lags behind it, as "
           "the lab believes; firn calibrate measures it"},
    Option{"offset_x_mm", &LaserPointConfig::offset_x_mm, "mm", within(-100, 100),
           "of the spot beyond the machine's tool_laser, as the lab believes; firn calibrate measures it"},
    Option{"offset_y_mm", &LaserPointConfig::offset_y_mm, "mm", within(-100, 100), "the same along y"},
    Option{"offset_z_mm", &LaserPointConfig::offset_z_mm, "mm", within(-100, 100), "added to every height"},
    Option{"bias_limit_mm", &LaserPointConfig::bias_limit_mm, "mm", within(0, 100),
           "calibrated uncertainty of heights (interlock 15); 0 = not checked"},
    Option{"offset_limit_mm", &LaserPointConfig::offset_limit_mm, "mm", within(0, 100),
           "calibrated uncertainty of the spot and of nozzles (interlock 15); 0 = not checked"},
    Option{"program_part", &LaserPointConfig::program_part, "", within(0, 7),
           "the controller's stored settings for ice"},
    Option{"program_scaffold", &LaserPointConfig::program_scaffold, "", within(0, 7), "and for scaffold"},
    Option{"surface_part", &LaserPointConfig::surface_part, "", within(0, 4),
           "its kind of surface for ice: 0 normal, 1 translucent, 2, 3 transparent, 4 multi-reflective"},
    Option{"surface_scaffold", &LaserPointConfig::surface_scaffold, "", within(0, 4), "and for scaffold"},
    Option{"sampling_us", &LaserPointConfig::sampling_us, "us", within(20, 1000), "its own sampling period"},
    Option{"averaging", &LaserPointConfig::averaging, "", within(0, 9), "over 4 to this power"},
    Option{"poll_idle_s", &LaserPointConfig::poll_idle_s, "s", above(0, 60),
           "between status questions at rest"},
};

}  // namespace firn::drivers
