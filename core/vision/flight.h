// flight_time_s computes how long a droplet falls through the gap below its nozzle, slowed by the air.
#pragma once

namespace firn::vision {

/// A droplet as a strobe sweep shows it: its velocity at a time after it left the nozzle.
struct Flyer {
  double velocity_mm_s = 0.0, at_s = 0.0, diameter_mm = 0.0;
};

/// Drag of a sphere in air at 20 degC, (1 + 0.15 Re^0.687) times Stokes' [Schiller and Naumann 1933], the
/// exponent as 11/16; midpoint rule. The droplet's density is that of water: ten per cent of it change the
/// time through 1 mm at 1 m/s by 0.2 %. A diameter of 0: no drag.
/// @returns infinity where the air stops it before; 0 for a velocity or a gap that is not above 0
double flight_time_s(const Flyer& flyer, double gap_mm);

}  // namespace firn::vision
