// LampConfig holds the settings of the UV lamp, with range and meaning of each.
#pragma once

#include <string>

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

/// Texts that differ between units or are not certain: a table, not code. "CLOSED" or "CLOSE" answers
/// `disconnect`, "Received" most commands, "Err67" any: the start counts.
struct LampDialect {
  std::string connect = "CONN", ready = "READY";
  std::string disconnect = "DCON", disconnected = "CLOSE";
  std::string open = "OPN", close = "CLS", iris = "SIL", received = "Received", error = "Err";
  std::string set_time = "STM", get_time = "GTM", run = "RUN";
  std::string status = "GUS", version = "VEB", lamp_on = "TON", lamp_off = "TOF", hours = "GLH";
  std::string serial = "GSN";
};
inline constexpr OptionTable kLampDialect{
    Option{"connect", &LampDialect::connect, "", Range{}, "takes the lamp over from its panel [C]"},
    Option{"ready", &LampDialect::ready, "", Range{}, "answer to connect [C]"},
    Option{"disconnect", &LampDialect::disconnect, "", Range{}, "gives it back to its panel [C]"},
    Option{"disconnected", &LampDialect::disconnected, "", Range{}, "answer to disconnect, its start [C]"},
    Option{"open", &LampDialect::open, "", Range{}, "opens the shutter [C]"},
    Option{"close", &LampDialect::close, "", Range{}, "closes the shutter, also during run [C]"},
    Option{"iris", &LampDialect::iris, "", Range{}, "iris in percent, with the number behind it [C]"},
    Option{"received", &LampDialect::received, "", Range{}, "answer to what is obeyed [C]"},
    Option{"error", &LampDialect::error, "", Range{}, "answer to what is not [C]"},
    Option{"set_time", &LampDialect::set_time, "", Range{}, "time of run in tenths of a second [S]"},
    Option{"get_time", &LampDialect::get_time, "", Range{}, "reads it back [C]"},
    Option{"run", &LampDialect::run, "", Range{}, "opens the shutter for that time [S]"},
    Option{"status", &LampDialect::status, "", Range{}, "asks for the status bits [S]"},
    Option{"version", &LampDialect::version, "", Range{}, "asks for the board's version [S]"},
    Option{"lamp_on", &LampDialect::lamp_on, "", Range{}, "lights the lamp [S]"},
    Option{"lamp_off", &LampDialect::lamp_off, "", Range{}, "puts it out [S]"},
    Option{"hours", &LampDialect::hours, "", Range{}, "asks for the lamp's hours [S]"},
    Option{"serial", &LampDialect::serial, "", Range{}, "asks for the serial number [S]"},
};

struct LampConfig {
  double max_on_s = 20.0;  ///< interlock I9
  OnOff status_bits = OnOff::kOn;
  OnOff auto_on = OnOff::kOn;
  double warm_up_s = 300.0;
  LampDialect dialect = {};  ///< [devices.lamp.dialect]
};
inline constexpr OptionTable kLampConfig{
    Option{"max_on_s", &LampConfig::max_on_s, "s", above(0, 3600),
           "longest exposure before the interlock closes the shutter"},
    Option{"status_bits", &LampConfig::status_bits, "", Range{},
           "GUS is read before an exposure, after the shutter was opened and after it was closed [S]"},
    Option{"auto_on", &LampConfig::auto_on, "", Range{},
           "a lamp that does not burn is switched on by TON, once a connection [S]"},
    Option{"warm_up_s", &LampConfig::warm_up_s, "s", within(0, 3600),
           "longest wait of an exposure for a lamp that burns and is not ready"},
};

}  // namespace firn::drivers
