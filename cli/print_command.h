// run_print prints an experiment live or in one process, or resumes an interrupted run.
#pragma once

#include "cli/print_run.h"

namespace firn {

int run_print(const Product& product, const PrintOptions& options);

}  // namespace firn
