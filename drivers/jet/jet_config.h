// JetConfig holds waveform and rate of a jet, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

inline constexpr double kMaxJet_v = 100.0;    ///< of a waveform, either sign (I11)
inline constexpr double kMaxJet_us = 3276.7;  ///< of each of its times (I11): 15 bits of 0.1 us

struct JetConfig {
  double dwell_us = 20.0, echo_us = 40.0, rise_us = 3.0, fall_us = 3.0, final_us = 3.0;
  double idle_v = 0.0, dwell_v = 20.0, echo_v = -20.0;  ///< whole volts
  int max_rate_hz = 2000;
};
inline constexpr OptionTable kJetConfig{
    Option{"dwell_us", &JetConfig::dwell_us, "us", above(0, kMaxJet_us), "waveform: time at dwell_v"},
    Option{"echo_us", &JetConfig::echo_us, "us", within(0, kMaxJet_us), "waveform: time at echo_v"},
    Option{"rise_us", &JetConfig::rise_us, "us", within(1, kMaxJet_us), "waveform: idle to dwell"},
    Option{"fall_us", &JetConfig::fall_us, "us", within(1, kMaxJet_us), "waveform: dwell to echo"},
    Option{"final_us", &JetConfig::final_us, "us", within(1, kMaxJet_us), "waveform: echo to idle"},
    Option{"idle_v", &JetConfig::idle_v, "V", within(-kMaxJet_v, kMaxJet_v), "waveform: level at rest"},
    Option{"dwell_v", &JetConfig::dwell_v, "V", within(-kMaxJet_v, kMaxJet_v), "waveform: first pulse"},
    Option{"echo_v", &JetConfig::echo_v, "V", within(-kMaxJet_v, kMaxJet_v), "waveform: second pulse"},
    Option{"max_rate_hz", &JetConfig::max_rate_hz, "Hz", within(1, 30'000), "droplet rate that stays stable"},
};

}  // namespace firn::drivers
