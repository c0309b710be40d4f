// Checks of an experiment before anything of its run is written.
#pragma once

#include <string>

#include "config/experiment.h"

namespace firn {

/// Checks the demands of an experiment on the simulated world and on the bus that no range of a single key
/// holds.
/// @param bus "" = live on the run's own port, "in-process", or an LCM URL
/// @throws UsageError naming the key and the limit that is broken
void check_print(const Experiment& experiment, const std::string& bus);

}  // namespace firn
