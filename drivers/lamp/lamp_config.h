// LampConfig holds the settings of the UV lamp, with range and meaning of each.
#pragma once

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

struct LampConfig {
  double max_on_s = 20.0;  ///< interlock I9
  OnOff status_bits = OnOff::kOn;
  OnOff auto_on = OnOff::kOn;
  double warm_up_s = 300.0;
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
