// LaserPointConfig holds the settings of the point laser, with range and meaning of each.
#pragma once

#include <string>

#include "core/options/option.h"

namespace firn::drivers {

/// Texts and codes that differ between models or are not certain: a table, not code.
struct LaserPointDialect {
  std::string measure = "M1";
  std::string enter = "Q0", leave = "R0";
  std::string select = "PW", selected = "PR";
  std::string clear = "AQ", start = "AS", stop = "AP";
  /// `AN,<0 stopped, 1 storing>,<values of output 1>,<of output 2>`, or without the second.
  std::string stored = "AN";
  std::string dump = "AO,1";             ///< `AO,<value>,<value>,…`, or `AO,1,<value>,…`
  std::string sampling = "SW,CA,";       ///< code: 0 20 us, 1 50, 2 100, 3 200, 4 500, 5 1000
  std::string averaging = "SW,OC,1,0,";  ///< k: 4^k values
  std::string material = "SW,HB,1,";     ///< 0 normal, 1 translucent, 2 transparent, 3, 4 multi-reflective
  std::string storage = "SW,CI,1,";      ///< `nnnnn,c`: values, and every how many samples one is stored
  int most_stored = 65536;
  int value_bytes = 9;
  double byte_s = 10.0 / 115200.0;
};
inline constexpr OptionTable kLaserPointDialect{
    Option{"measure", &LaserPointDialect::measure, "", Range{}, "one value of output 1 [C]"},
    Option{"enter", &LaserPointDialect::enter, "", Range{}, "to communication mode: nothing is measured [C]"},
    Option{"leave", &LaserPointDialect::leave, "", Range{}, "back to measuring [C]"},
    Option{"select", &LaserPointDialect::select, "", Range{}, "program, with its number behind a comma [S]"},
    Option{"selected", &LaserPointDialect::selected, "", Range{}, "asks for the program [S]"},
    Option{"clear", &LaserPointDialect::clear, "", Range{}, "empties the storage [C]"},
    Option{"start", &LaserPointDialect::start, "", Range{}, "the storage begins with the trigger [C]"},
    Option{"stop", &LaserPointDialect::stop, "", Range{}, "ends the storage [C]"},
    Option{"stored", &LaserPointDialect::stored, "", Range{}, "asks for the number of stored values [C]"},
    Option{"dump", &LaserPointDialect::dump, "", Range{}, "the stored values; LK-G5000: AO,01 [C]"},
    Option{"sampling", &LaserPointDialect::sampling, "", Range{},
           "sampling period, with its code behind it [S]"},
    Option{"averaging", &LaserPointDialect::averaging, "", Range{}, "average, with its code behind it [S]"},
    Option{"material", &LaserPointDialect::material, "", Range{},
           "kind of surface, with its number behind it [S]"},
    Option{"storage", &LaserPointDialect::storage, "", Range{},
           "values to store and cycle code behind it; the codes are ours [P]"},
    Option{"most_stored", &LaserPointDialect::most_stored, "", within(1, 65536),
           "values that the storage holds [Barnett 2012, Table 2-3] [S]"},
    Option{"value_bytes", &LaserPointDialect::value_bytes, "", within(9, 10),
           "of a value in a dump, with its comma; LK-G5000: 10 [S]"},
    Option{"byte_s", &LaserPointDialect::byte_s, "s", above(0, 0.01),
           "of a byte on the line: a dump is awaited so long [C]"},
};

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
  LaserPointDialect dialect = {};  ///< [devices.laser_point.dialect]
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
