// JetConfig holds waveform and rate of a jet, with range and meaning of each.
#pragma once

#include <array>
#include <string>

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

inline constexpr double kMaxJet_v = 100.0;    ///< of a waveform, either sign (I11)
inline constexpr double kMaxJet_us = 3276.7;  ///< of each of its times (I11): 15 bits of 0.1 us

enum class JetKind : std::uint8_t { kJetdrive, kMicrodrop };
inline constexpr std::array<std::string_view, 2> kJetKindWords{"jetdrive", "microdrop"};
constexpr std::span<const std::string_view> words_of(JetKind) { return kJetKindWords; }

/// Caps of the head, and the parts of a reply: 06h or 15h, command, status, (version,) sum of the bytes
/// between. Their order is not certain: a table, not code.
struct JetDialect {
  int max_abs_v = int(kMaxJet_v);
  double max_time_us = kMaxJet_us;
  int ack = 0x06, nak = 0x15;
  int command_at = 1, status_at = 2, size = 4, version_size = 5;
  int poll_tells_source_from = 128;  ///< firmware version; before it POLL's status has no meaning
  int source_bit = 4;                ///< of POLL's status: the source is external
  int strobe_divider = 1, strobe_delay_us = 0;
  double most_continuous_s = 180.0;
};
inline constexpr OptionTable kJetDialect{
    Option{"max_abs_v", &JetDialect::max_abs_v, "V", within(1, kMaxJet_v),
           "the head's: no level of a waveform is beyond it, either sign (I11) [P]"},
    Option{"max_time_us", &JetDialect::max_time_us, "us", within(1, kMaxJet_us),
           "no time of a waveform is longer (I11) [P]"},
    Option{"ack", &JetDialect::ack, "", within(0, 255), "first byte of a reply: obeyed [S]"},
    Option{"nak", &JetDialect::nak, "", within(0, 255), "refused [S]"},
    Option{"command_at", &JetDialect::command_at, "", within(1, 15), "place of the command in a reply [P]"},
    Option{"status_at", &JetDialect::status_at, "", within(1, 15), "place of the status [P]"},
    Option{"size", &JetDialect::size, "", within(3, 16), "bytes of a reply [S]"},
    Option{"version_size", &JetDialect::version_size, "", within(3, 16), "bytes of that to GETVERSION [S]"},
    Option{"poll_tells_source_from", &JetDialect::poll_tells_source_from, "", within(0, 256),
           "firmware whose POLL tells the trigger source; 256 = none [P]"},
    Option{"source_bit", &JetDialect::source_bit, "", within(1, 255),
           "of POLL's status: external, as in DUMP's [P]"},
    Option{"strobe_divider", &JetDialect::strobe_divider, "", within(1, 255), "droplets of one flash [S]"},
    Option{"strobe_delay_us", &JetDialect::strobe_delay_us, "us", within(0, 65535),
           "from the droplet's pulse to the flash [S]"},
    Option{"most_continuous_s", &JetDialect::most_continuous_s, "s", above(0, 600),
           "longest continuous jetting by firn device: the JetDrive itself has no limit [P]"},
};

struct JetConfig {
  double dwell_us = 20.0, echo_us = 40.0, rise_us = 3.0, fall_us = 3.0, final_us = 3.0;
  double idle_v = 0.0, dwell_v = 20.0, echo_v = -20.0;  ///< whole volts
  double small_dwell_v = 14.0, small_echo_v = -14.0;
  int max_rate_hz = 2000;
  JetKind kind = JetKind::kJetdrive;
  std::string trigger_on = {}, trigger_off = {};
  OnOff keep_firmware = OnOff::kOn;
  JetDialect dialect = {};  ///< [devices.jet.dialect], [devices.jet_b.dialect]
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
    Option{"small_dwell_v", &JetConfig::small_dwell_v, "V", within(-kMaxJet_v, kMaxJet_v),
           "the same for small droplets (actuation.small_share), whose other values are those above"},
    Option{"small_echo_v", &JetConfig::small_echo_v, "V", within(-kMaxJet_v, kMaxJet_v),
           "the second pulse for small droplets"},
    Option{"max_rate_hz", &JetConfig::max_rate_hz, "Hz", within(1, 30'000), "droplet rate that stays stable"},
    Option{"kind", &JetConfig::kind, "", Range{},
           "jetdrive: MicroFab JetDrive III; microdrop: Microdrop MD-E, whose pulse is dwell_v for dwell_us "
           "[S]"},
    Option{"trigger_on", &JetConfig::trigger_on, "", Range{},
           "microdrop: command that makes it fire by its trigger input, from the unit's manual; empty: none, "
           "and no pass can be printed [P]"},
    Option{"trigger_off", &JetConfig::trigger_off, "", Range{}, "microdrop: command that ends it [P]"},
    Option{
        "keep_firmware", &JetConfig::keep_firmware, "", Range{},
        "a JetDrive that answers POLL after a lost link has kept its power: it is set up without a start of "
        "its firmware and RESET, which take 5 s [P]"},
};

}  // namespace firn::drivers
