// cost_of() computes the cost of a cell's error. Lu's objective is the sum of |e| (alpha = 1). The linear and
// square terms are the majorant of a standard deviation (weighted_layer.h). Height that a droplet adds beside
// the part has a price of its own, linear in the droplets.
#pragma once

#include <cmath>

namespace firn::control::mpc {

/// absolute |e| + (linear + square e) e: 0 for e = 0, so that cells that do not count cost nothing.
struct CellCost {
  float absolute = 1.0f;
  float linear = 0.0f;
  float square = 0.0f;  ///< per mm
  float outside =
      0.0f;  ///< of each mm that a droplet adds to cells that do not count (MpcOptions::outside_price)
};

inline bool is_plain(const CellCost& c) { return c.absolute == 1.0f && c.linear == 0.0f && c.square == 0.0f; }

/// In double precision: sums and gains are compared by it.
inline double cost_of(const CellCost& c, double error_mm) {
  return is_plain(c) ? std::abs(error_mm)
                     : double(c.absolute) * std::abs(error_mm) +
                           (double(c.linear) + double(c.square) * error_mm) * error_mm;
}

}  // namespace firn::control::mpc
