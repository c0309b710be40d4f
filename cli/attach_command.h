// run_attach shows the progress of a print that runs in another process, and hands keys to it.
#pragma once

#include <string>

namespace firn {

class OptionSet;

struct AttachOptions {
  std::string run;  ///< run folder
};

/// Returns the exit code of the print when it ends. Ctrl-C leaves the print running.
/// @throws UsageError: a run that is not running
int run_attach(const AttachOptions& options);

/// Declares the arguments.
void declare_attach(OptionSet& options);

}  // namespace firn
