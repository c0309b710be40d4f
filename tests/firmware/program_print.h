// The print of whole_print_test.cpp and of build/bench/trigger_chain: a block of ice of 20 x 20 x 3.6 mm, its
// instruments the twins of the protocols, or the V+ text and the valves' firmware.
#pragma once

#include <string>
#include <vector>

#include "tests/print/ice_runs.h"

namespace firn::test {

enum class Instruments { kTwins, kPrograms };

/// Returns overrides of experiments/ice-small.toml: nature without debris and roughness, so that two prints
/// differ by their instruments alone.
inline std::vector<std::string> block_print(Instruments instruments) {
  std::vector<std::string> overrides{"plant.ice.debris_per_h=0", "plant.ice.roughness=0"};
  if (instruments == Instruments::kPrograms) overrides.push_back("plant.ice.instruments=programs");
  return overrides;
}

/// Lets the valves execute their binary for the ATmega2560.
void with_binaries(plant::WorldConfig& config);

}  // namespace firn::test
