// ThinFilmOptions holds the parameters of a world in which wet ink flows as a thin liquid film.
#pragma once

#include "core/options/option.h"

namespace firn::plant {

/// Values of the ink marked [U] are assumed: typical of UV ink-jet inks, 8 to 20 mPa s at the head, 22 to 36
/// mN/m.
struct ThinFilmOptions {
  double wet_s = 1.0;
  double surface_tension_N_m = 0.03;
  double viscosity_Pa_s = 0.02;
  double gel_s = 0.3;
  double gel_power = 2.0;
  double advancing_deg = 4.4;
  double radius_mm = 0.18;
  double precursor_mm = 1e-4;
  int fine_cells = 3;
  int margin_cells = 3;
  double group_s = 0.5;
  double most_slope = 0.3;
  double most_depth = 0.5;
  bool operator==(const ThinFilmOptions&) const = default;
};
inline constexpr OptionTable kThinFilmOptions{
    Option{"wet_s", &ThinFilmOptions::wet_s, "s", within(0, 3600),
           "time from the last droplet of a layer to its lamp, in which the film levels; 0 = as the lab's "
           "clock has it"},
    Option{"surface_tension_N_m", &ThinFilmOptions::surface_tension_N_m, "N/m", within(0.001, 0.1),
           "of the ink [U]"},
    Option{"viscosity_Pa_s", &ThinFilmOptions::viscosity_Pa_s, "Pa s", within(1e-4, 100),
           "of the uncured ink [U]"},
    Option{"gel_s", &ThinFilmOptions::gel_s, "s", within(0, 100),
           "time under the lamp until the ink gels; its viscosity rises until then [U]"},
    Option{"gel_power", &ThinFilmOptions::gel_power, "", within(0, 10),
           "b of viscosity / (1 - conversion / conversion at the gel)^b, after Castro and Macosko [U]"},
    Option{"advancing_deg", &ThinFilmOptions::advancing_deg, "deg", within(0.5, 15),
           "angle above which a contact line advances; 4.4 is that of a droplet of this volume 413 um across "
           "[Lu 2015, "
           "Fig. 18]"},
    Option{"radius_mm", &ThinFilmOptions::radius_mm, "mm", within(0.05, 1), "of a droplet as it lands [U]"},
    Option{"precursor_mm", &ThinFilmOptions::precursor_mm, "mm", within(1e-6, 1e-3),
           "film on ground that a contact line has just passed"},
    Option{"fine_cells", &ThinFilmOptions::fine_cells, "", within(3, 6),
           "of the film for each cell of the grid"},
    Option{"margin_cells", &ThinFilmOptions::margin_cells, "cells", within(2, 50), "ground around the grid"},
    Option{"group_s", &ThinFilmOptions::group_s, "s", within(0.01, 100),
           "droplets that land within so long are added together: a drop spreads in 2 ms and levels in 14 "
           "ms, so that this "
           "matters where it is not far below wet_s"},
    Option{"most_slope", &ThinFilmOptions::most_slope, "", within(0.05, 0.5),
           "steepest ground over which ink flows; a wet surface that is steeper stops the print, as "
           "lubrication theory does "
           "not hold there"},
    Option{"most_depth", &ThinFilmOptions::most_depth, "", within(0.1, 0.5),
           "most 2 pi x film thickness by the pitch: a deeper film stops the print, as lubrication theory "
           "overstates its "
           "levelling by 29 % there [Orchard]"},
};

}  // namespace firn::plant
