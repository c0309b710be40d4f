// WatchOptions holds the strobe sweeps of a print and the band in which its jet must be, with their table.
#pragma once

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::droplet {

struct WatchOptions {
  OnOff gate = OnOff::kOff;
  OnOff placement = OnOff::kOff;
  int every_layers = 0;
  int frames = 12;
  double first_us = 60.0;
  double step_us = 12.0;
  double um_per_px = 0.0;
  double nozzle_um = 0.0;
  double velocity_least_m_s = 1.0;
  double velocity_most_m_s = 6.0;
  double angle_most_deg = 3.0;
  double satellites_most = 0.0;
  double purge_s = 1.0;
  double x_mm = -5.0;
  double y_mm = -5.0;
};
inline constexpr OptionTable kWatchOptions{
    Option{"gate", &WatchOptions::gate, "", Range{},
           "on: a strobe sweep before layer 1; a jet outside the band is purged once, then the print stops "
           "(I11)"},
    Option{"placement", &WatchOptions::placement, "", Range{},
           "on: a sweep before layer 1, and pulses of each row come earlier by what the droplet flies with "
           "the stage: pass speed x nozzle gap / velocity"},
    Option{"every_layers", &WatchOptions::every_layers, "layers", within(0, 1e6),
           "a sweep again after so many layers; 0 = before layer 1 alone"},
    Option{"frames", &WatchOptions::frames, "", within(2, 1000), "pictures of a sweep"},
    Option{"first_us", &WatchOptions::first_us, "us", within(0, 1e6), "strobe delay of its first picture"},
    Option{"step_us", &WatchOptions::step_us, "us", above(0, 1e6), "from picture to picture"},
    Option{"um_per_px", &WatchOptions::um_per_px, "um", within(0, 1e4),
           "scale of the pictures; 0 = by the nozzle's width"},
    Option{"nozzle_um", &WatchOptions::nozzle_um, "um", within(0, 1e5),
           "width of the nozzle in the pictures; 0 = not known"},
    Option{"velocity_least_m_s", &WatchOptions::velocity_least_m_s, "m/s", above(0, 100), "gate: at least"},
    Option{"velocity_most_m_s", &WatchOptions::velocity_most_m_s, "m/s", above(0, 100), "gate: at most"},
    Option{"angle_most_deg", &WatchOptions::angle_most_deg, "deg", above(0, 90),
           "gate: from the nozzle's axis, either side, at most"},
    Option{"satellites_most", &WatchOptions::satellites_most, "", within(0, 100), "gate: at most so many"},
    Option{"purge_s", &WatchOptions::purge_s, "s", above(0, 60), "gate: jetting between the two sweeps"},
    Option{"x_mm", &WatchOptions::x_mm, "mm", within(-1e4, 1e4), "stage where the camera sees the nozzle"},
    Option{"y_mm", &WatchOptions::y_mm, "mm", within(-1e4, 1e4), "the same along y"},
};

}  // namespace firn::droplet
