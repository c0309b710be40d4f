// run_print prints an experiment live or in one process, or resumes an interrupted run.
#pragma once

#include "cli/print_run.h"

namespace firn {

class OptionSet;

int run_print(const PrintOptions& options);

/// Declares the arguments.
void declare_print(OptionSet& options);

}  // namespace firn
