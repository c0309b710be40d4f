// run_runs lists, finds, packs and removes run folders.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct RunsOptions {
  std::vector<std::string>
      words;  ///< {}, {"list"}, {"find", WORD}, {"clean"}, {"pack", RUN…}, {"expand", RUN…}
  std::string runs = "runs";  ///< folder of the run folders
  std::optional<double> older_than_days;
  std::optional<int> keep;  ///< of the newest runs
  std::string outcome;
  bool yes = false;  ///< clean removes
  bool json = false;
};

/// @throws UsageError: an unknown action, a run folder that is none
int run_runs(const RunsOptions& options);

/// Declares the arguments.
void declare_runs(OptionSet& options);

}  // namespace firn
