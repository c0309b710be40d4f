// HeaterConfig holds the settings of an end effector's heaters or of a platen's, with range and meaning of
// each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

inline constexpr double kHeaterOff_degC = -50.0;  ///< a set point at or below it: off

struct HeaterConfig {
  double tip_degC = 20.0;                ///< (a) end effector's tip
  double window_degC = 22.0;             ///< (b) laser window
  double conduit_degC = 20.0;            ///< (c) flexible conduit
  double platen_degC = kHeaterOff_degC;  ///< in the place of (a), where a platen is all there is
  double poll_s = 1.0;
  double low_degC = 5.0;    ///< a channel that was warmer and falls below it is too cold
  double high_degC = 45.0;  ///< too hot: it is switched off
  double no_rise_s = 60.0;  ///< on all the time, below its set point, and not 2 degC warmer
  double frozen_s = 40.0;   ///< the reading does not move at all while the heater works
};
inline constexpr OptionTable kHeaterConfig{
    Option{"tip_degC", &HeaterConfig::tip_degC, "degC", within(-40, 100),
           "set point (a): end effector's tip, at the valves"},
    Option{"window_degC", &HeaterConfig::window_degC, "degC", within(-40, 100),
           "set point (b): laser window"},
    Option{"conduit_degC", &HeaterConfig::conduit_degC, "degC", within(-40, 100), "set point (c): conduit"},
    Option{"platen_degC", &HeaterConfig::platen_degC, "degC", within(kHeaterOff_degC, 200),
           "set point of an aerosol printer's platen, channel 1 of the box; -50 = it has no heater"},
    Option{"poll_s", &HeaterConfig::poll_s, "s", above(0, 10), "between readings"},
    Option{"low_degC", &HeaterConfig::low_degC, "degC", within(-40, 100),
           "below it the valves freeze, or the platen is too cold: nothing is deposited (I10)"},
    Option{"high_degC", &HeaterConfig::high_degC, "degC", within(-40, 200),
           "above it the heaters go off (I10)"},
    Option{"no_rise_s", &HeaterConfig::no_rise_s, "s", above(0, 3600),
           "a heater that is on and does not warm in so long has failed"},
    Option{"frozen_s", &HeaterConfig::frozen_s, "s", above(0, 3600),
           "a reading that does not move at all in so long has failed"},
};

}  // namespace firn::drivers
