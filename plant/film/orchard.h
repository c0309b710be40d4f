// Rates at which waves on a liquid film level, by linear theory: the oracle of the film's tests, and the
// measure of its validity.
#pragma once

#include <cmath>

namespace firn::plant {

/// Returns the rate [1/s] at which a small wave of wave number k [1/mm] on a film of thickness h [mm] decays
/// under surface tension, in lubrication theory: speed h^3 k^4 / 3, speed = surface tension / viscosity
/// [mm/s] [S. E. Orchard, Appl. Sci. Res. A 11 (1963) 451, thin].
inline double orchard_thin_rate(double speed_mm_s, double h_mm, double k_per_mm) {
  return speed_mm_s * h_mm * h_mm * h_mm * k_per_mm * k_per_mm * k_per_mm * k_per_mm / 3.0;
}

/// Returns the same rate of Stokes flow, at any depth: speed k / 2 (sinh x cosh x - x) / (cosh^2 x + x^2), x
/// = k h.
inline double orchard_rate(double speed_mm_s, double h_mm, double k_per_mm) {
  const double x = k_per_mm * h_mm, c = std::cosh(x);
  return 0.5 * speed_mm_s * k_per_mm * (std::sinh(x) * c - x) / (c * c + x * x);
}

/// Returns the true rate by that of lubrication theory: 1 for x -> 0, 0.94 at 0.18, 0.71 at 0.48.
inline double orchard_ratio(double x) { return orchard_rate(1.0, x, 1.0) / orchard_thin_rate(1.0, x, 1.0); }

}  // namespace firn::plant
