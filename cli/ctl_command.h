// run_ctl sends one order of the operator to a running print.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct CtlOptions {
  std::string run;                 ///< run folder
  std::vector<std::string> words;  ///< {"pause"}, {"set", "KEY=VALUE"}
  std::int64_t id = 0;             ///< of the order; 0 = a new one
  bool json = false;
};

/// @returns 0 obeyed, 1 no answer, 2 refused
/// @throws UsageError: an unknown order, a run that is not running
int run_ctl(const CtlOptions& options);

/// Declares the arguments.
void declare_ctl(OptionSet& options);

}  // namespace firn
