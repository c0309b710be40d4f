// require_within() and require_above() check a parameter of the simulated world against its range.
#pragma once

#include <string>

#include "core/options/require.h"

namespace firn::plant {

/// @throws std::invalid_argument "world: <field> = <value> is outside <low> .. <high>"
inline void require_within(const std::string& field, double value, double low, double high) {
  if (!(value >= low && value <= high))
    refuse("world", field + " = " + std::to_string(value) + " is outside " + std::to_string(low) + " .. " +
                        std::to_string(high));
}

/// The same of a range without its low end.
inline void require_above(const std::string& field, double value, double low, double high) {
  if (!(value > low && value <= high))
    refuse("world", field + " = " + std::to_string(value) + " is not above " + std::to_string(low) +
                        " and up to " + std::to_string(high));
}

}  // namespace firn::plant
