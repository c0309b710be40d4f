// run_reproduce sets every table and figure of the papers beside the values computed here.
#pragma once

#include "studies/reproduce/reproduce.h"

namespace firn {

class OptionSet;

/// @returns 0, or 1 when a row disagrees for no known reason or a part cannot be computed. @throws UsageError
int run_reproduce(const ReproduceOptions& options);

/// Declares the arguments.
void declare_reproduce(OptionSet& options);

}  // namespace firn
