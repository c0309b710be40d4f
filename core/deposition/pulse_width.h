// plan_widths() computes pulse-width modulation, the alternative to frequency modulation: pulses at a fixed
// frequency whose width carries the flow [Barnett 2012, 6.1]. The thesis rejects it because a pulse cannot be
// narrower than 0.5 ms; here it serves for comparison.
#pragma once

#include <span>
#include <vector>

#include "core/deposition/delivery.h"
#include "core/deposition/flow_demand.h"
#include "core/deposition/monotone_curve.h"
#include "core/deposition/valve.h"

namespace firn::deposition {

struct WidthModulation {
  double period_s = 0.008;  ///< at least one drop per mm at 125 mm/s: 125 Hz
  MonotoneCurve dose;       ///< drop volume [mm^3] against pulse width [s], from min_pulse_s to the period
  /// The volume error of a period is carried into the next one. Without it a flow below that of the narrowest
  /// pulse is rounded to the narrowest pulse or to no pulse.
  bool carry = false;
};
/// A valve that passes `open_flow` while it is open, the ideal of Table 2-2: dose = open_flow * width.
WidthModulation ideal_width_modulation(double open_flow_mm3_s, double period_s, const ValveLimits& limits);

/// @throws std::invalid_argument: the dose table leaves [min_pulse_s, period], no dose at its start, period
/// below a tick
void check(const WidthModulation& modulation, const ValveLimits& limits);

struct WidthPulse {
  double centre_s = 0.0;
  double width_s = 0.0;
  double dose_mm3 = 0.0;
};
/// One pulse per period, in its middle, or none where the flow is too small.
/// @throws std::invalid_argument: check(demand), check(modulation)
std::vector<WidthPulse> plan_widths(const FlowDemand& demand, const WidthModulation& modulation,
                                    const ValveLimits& limits);

std::vector<Drop> drops_of(std::span<const WidthPulse> pulses);

}  // namespace firn::deposition
