// run_print prints an experiment live or in one process, or resumes an interrupted run.
#pragma once

#include <string>

#include "cli/print_run.h"

namespace firn {

struct PrintEnd {
  int code = 0;           ///< exit code
  std::string run;        ///< folder
  std::string last_line;  ///< its verdict, or how it goes on
};

/// Prints, or resumes, and shows progress and end. @throws UsageError: it was refused, nothing was begun
PrintEnd carry_out(const Product& product, const PrintOptions& options);

/// The same, as a command.
int run_print(const Product& product, const PrintOptions& options);

}  // namespace firn
