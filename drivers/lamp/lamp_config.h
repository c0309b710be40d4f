// LampConfig holds the settings of the UV lamp, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

struct LampConfig {
  double max_on_s = 20.0;  ///< interlock I9
};
inline constexpr OptionTable kLampConfig{
    Option{"max_on_s", &LampConfig::max_on_s, "s", above(0, 3600),
           "longest exposure before the interlock closes the shutter"},
};

}  // namespace firn::drivers
