// ThermometerConfig holds the settings of the bed's thermometer, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

struct ThermometerConfig {
  double poll_s = 1.0;
};
inline constexpr OptionTable kThermometerConfig{
    Option{"poll_s", &ThermometerConfig::poll_s, "s", above(0, 10), "between readings"},
};

}  // namespace firn::drivers
