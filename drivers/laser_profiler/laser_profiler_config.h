// LaserProfilerConfig holds the settings of the laser profiler, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

struct LaserProfilerConfig {
  int points = 800;
  double dx_mm = 0.0;            ///< 0 = chosen so that the line covers the grid
  double offset_y_mm = 0.0;      ///< line relative to the nozzle
  double bias_limit_mm = 0.005;  ///< calibrated uncertainty of heights; 0: the bare table is not checked
  double offset_limit_mm = 0.2;  ///< and of places; 0: the first layer's outline is not checked
  double poll_s = 0.004;  ///< while armed; must be shorter than the time between two triggers. Once two rows
                          ///< have come, the driver waits 9/10 of their distance before it asks again.
};
inline constexpr OptionTable kLaserProfilerConfig{
    Option{"points", &LaserProfilerConfig::points, "", within(2, 800), "points of one profile"},
    Option{"dx_mm", &LaserProfilerConfig::dx_mm, "mm", within(0, 10),
           "distance of points; 0 = so that the line covers the grid"},
    Option{"offset_y_mm", &LaserProfilerConfig::offset_y_mm, "mm", within(-1000, 1000),
           "laser line relative to the nozzle"},
    Option{"bias_limit_mm", &LaserProfilerConfig::bias_limit_mm, "mm", within(0, 100),
           "calibrated uncertainty of heights (interlock 15); 0 = not checked"},
    Option{"offset_limit_mm", &LaserProfilerConfig::offset_limit_mm, "mm", within(0, 100),
           "calibrated uncertainty of places (interlock 15); 0 = not checked"},
    Option{"poll_s", &LaserProfilerConfig::poll_s, "s", above(0, 10), "between questions for a new profile"},
};

}  // namespace firn::drivers
