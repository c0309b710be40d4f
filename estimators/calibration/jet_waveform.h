// Estimates the dwell time at which a jet's droplets are fastest, and the voltage that gives them a velocity.
#pragma once

#include <cstddef>
#include <span>

#include "estimators/calibration/robust_fit.h"

namespace firn::calibration {

/// Velocity of the droplets with one waveform, from a strobe sweep. A waveform without droplets is left out.
struct JetSpeed {
  double dwell_us = 0.0;
  double volts = 0.0;  ///< of the first pulse
  double velocity_m_s = 0.0, std_m_s = 0.0;
};

/// The speed that is the largest for sure: by the lower end of its 95 % interval, since a sweep of few
/// droplets may give any velocity. @param speeds one or more
const JetSpeed& fastest(std::span<const JetSpeed> speeds);

struct BestDwell {
  Estimate dwell_us, velocity_m_s;  ///< at the maximum
  double quadratic_m_s = 0.0, quartic_m_s = 0.0, half_width_us = 0.0;
  FitResult fit;  ///< residuals in standard deviations
  /// Velocity of the fitted curve.
  double at(double dwell_us) const;
};
/// v = v0 - b u^2 + c u^4 with u = (dwell - d0) / half the range of the data: two steps of a pulse drive the
/// nozzle's resonance as |sin(pi d / 2 d0)| [Bogy and Talke 1984], which is even about its maximum.
/// @throws Unidentifiable: fewer than six settings; a maximum at the end of the range; a fall towards its
/// ends that the noise hides
BestDwell fit_best_dwell(std::span<const JetSpeed> speeds);

struct VoltageLine {
  Estimate threshold_v, slope_m_s_v;
  Estimate volts;  ///< that give the wanted velocity
  FitResult fit;
  double at(double v) const { return slope_m_s_v.value * (v - threshold_v.value); }
};
inline constexpr std::size_t kMinVoltages = 4;
/// v = m (U - U0), at one dwell time. @throws Unidentifiable: fewer than kMinVoltages settings; a velocity
/// that does not rise with the voltage
VoltageLine fit_voltage(std::span<const JetSpeed> speeds, double wanted_m_s);

}  // namespace firn::calibration
