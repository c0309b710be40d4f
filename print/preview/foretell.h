// foretell() simulates the scheme that will print: how many layers it takes, and when each is done. The
// nominal number of layers is too small where feedback fills up a rim.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "config/experiment.h"
#include "print/labs/product.h"

namespace firn {

struct Foretold {
  std::map<int, double> layer_s;  ///< node time at the end of each layer [s]
  double time_s = 0.0;            ///< node time of the whole print
  std::int64_t amount = 0;        ///< droplets, pulses, switches
};

/// Prints the experiment in memory with the world of its [plant].
/// @param within_s of processor time; nothing if it takes longer, or if the simulated print does not finish
std::optional<Foretold> foretell(const Product& product, const Experiment& experiment, const Blobs& inputs,
                                 double within_s);

}  // namespace firn
