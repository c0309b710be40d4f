// Plans a print job on an aerosol machine (firn plan): computes the stage's trajectory and the shutter's
// commands.
#pragma once

#include "cli/plan_command.h"
#include "config/machine.h"

namespace firn {

/// Prints the report of all three ways of turning corners, the chosen one marked; writes the files of the
/// chosen one. Options of other machines are refused.
/// @returns 0; 1 when segments are refused (each is named with its reason, nothing is written). @throws
/// UsageError
int run_plan_aerosol(const Machine& machine, const PlanCommandOptions& options);

}  // namespace firn
