// display_unit_for() chooses the unit in which people read a length: records may be of droplets of some um or
// of beads of some mm.
#pragma once

#include <cmath>

namespace firn {

struct DisplayUnit {
  const char* name;
  double per_mm;
};

/// Returns mm for lengths of 1 mm or more, else um.
inline DisplayUnit display_unit_for(double largest_mm) {
  return std::abs(largest_mm) >= 1.0 ? DisplayUnit{"mm", 1.0} : DisplayUnit{"um", 1e3};
}

}  // namespace firn
