// warn_of_use names the limits of [lab.use] that a print comes near, before it begins.
#pragma once

#include "config/experiment.h"
#include "config/meta.h"

namespace firn {

/// Says on the error output which of the counters of this print's batch and instruments have come near their
/// limits, by the runs in `runs_folder`. Without a limit nothing is read.
void warn_of_use(const UseLimits& limits, const Meta& meta, const Experiment& experiment,
                 const std::string& runs_folder);

}  // namespace firn
