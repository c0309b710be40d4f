// JetConfig holds waveform and rate of a jet, with range and meaning of each.
#pragma once

#include <array>
#include <string>

#include "core/options/option.h"

namespace firn::drivers {

inline constexpr double kMaxJet_v = 100.0;    ///< of a waveform, either sign (I11)
inline constexpr double kMaxJet_us = 3276.7;  ///< of each of its times (I11): 15 bits of 0.1 us

enum class JetKind : std::uint8_t { kJetdrive, kMicrodrop };
inline constexpr std::array<std::string_view, 2> kJetKindWords{"jetdrive", "microdrop"};
constexpr std::span<const std::string_view> words_of(JetKind) { return kJetKindWords; }

struct JetConfig {
  double dwell_us = 20.0, echo_us = 40.0, rise_us = 3.0, fall_us = 3.0, final_us = 3.0;
  double idle_v = 0.0, dwell_v = 20.0, echo_v = -20.0;  ///< whole volts
  int max_rate_hz = 2000;
  JetKind kind = JetKind::kJetdrive;
  std::string trigger_on = {}, trigger_off = {};
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
    Option{"kind", &JetConfig::kind, "", Range{},
           "jetdrive: MicroFab JetDrive III; microdrop: Microdrop MD-E, whose pulse is dwell_v for dwell_us "
           "[S]"},
    Option{"trigger_on", &JetConfig::trigger_on, "", Range{},
           "microdrop: command that makes it fire by its trigger input, from the unit's manual; empty: none, "
           "and no pass can be printed [P]"},
    Option{"trigger_off", &JetConfig::trigger_off, "", Range{}, "microdrop: command that ends it [P]"},
};

}  // namespace firn::drivers
