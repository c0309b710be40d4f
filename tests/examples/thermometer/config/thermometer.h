// ThermometerConfig holds the lab's settings of the bed's thermometer.
#pragma once

namespace firn {

struct ThermometerConfig {
  double poll_s = 1.0;  ///< between readings
};

}  // namespace firn
