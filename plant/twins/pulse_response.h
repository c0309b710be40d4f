// jet_speed_m_s computes how fast a droplet leaves the nozzle after a pulse: an acoustic resonance driven by
// the two slopes of the pulse [Bogy and Talke 1984], above a threshold of amplitude [Dijksman 1984].
#pragma once

#include "plant/config/world_config.h"

namespace firn::plant {

/// The first pulse as the amplifier gives it.
struct JetPulse {
  double dwell_us = 0.0, rise_us = 0.0, fall_us = 0.0;
  double volts = 0.0;  ///< from rest
};

/// speed (U |sin(pi d / 2 D)| - U0) / (20 V - U0), d between the middles of the slopes, D = best_dwell_us.
/// The second pulse, which damps what remains, does not act.
/// @returns 0: nothing leaves the nozzle; StrobeParams::speed_m_s where best_dwell_us is 0
double jet_speed_m_s(const StrobeParams& jet, const JetPulse& pulse);

/// Volume of a droplet in shares of that after a pulse of 20 V, (U - U0) / (20 V - U0): like its speed it
/// grows linearly above the threshold U0 = StrobeParams::threshold_v [Dijksman 1984]. The dwell does not act.
/// @returns 0: nothing leaves the nozzle
double jet_volume_share(const StrobeParams& jet, const JetPulse& pulse);

}  // namespace firn::plant
