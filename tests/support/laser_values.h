// The instrument's side of the values that drivers/laser_point/lkg.h parses.
#pragma once

#include <cmath>
#include <cstring>

#include "drivers/laser_point/lkg.h"

namespace firn::drivers::lkg {

/// `+01.2345`, `-00.0120`: four decimals; NaN gives `XXXXXXXX`, beyond +-99.9999 `+FFFFFFF`, `-FFFFFFF`.
inline void put_value(double mm, char (&to)[kValueChars]) {
  if (std::isnan(mm)) {
    std::memcpy(to, "XXXXXXXX", kValueChars);
    return;
  }
  to[0] = mm < 0.0 ? '-' : '+';
  const double size = std::abs(mm);
  if (size > 99.9999) {
    std::memcpy(to + 1, "FFFFFFF", kValueChars - 1);
    return;
  }
  auto n = std::int32_t(std::floor(size * 1e4 + 0.5));
  for (int at = 7; at >= 1; --at) {
    if (at == 3) {
      to[at] = '.';
      continue;
    }
    to[at] = char('0' + n % 10);
    n /= 10;
  }
}

}  // namespace firn::drivers::lkg
