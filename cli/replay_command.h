// run_replay replays every node of a run from its own write-ahead file and reports the first divergence.
#pragma once

#include <string>
#include <vector>

#include "replay/options.h"
#include "replay/verdict.h"

namespace firn {

struct Product;

struct ReplayCommandOptions {
  std::string run;                     ///< run folder
  std::string node;                    ///< empty = all
  double tolerance = 0.0;              ///< numeric fields that differ by no more are equal
  std::vector<std::string> ignores;    ///< "FIELD=reason"
  std::vector<std::string> overrides;  ///< "a.b=value"
  int threads = 0;                     ///< 0 = as many as the machine has
  bool stopwatch = false;              ///< measures the handlers
  replay::RunPython run_python = replay::RunPython::kOwn;
  bool any_python = false;  ///< --run-python
  bool json = false;
};

/// @throws UsageError, ConfigError
replay::RunVerdict replay_verdict(const Product& product, const ReplayCommandOptions& options);

/// Prints the verdict. @returns 0 identical, 1 differs, 2 usage or a file that cannot be read
int run_replay(const Product& product, const ReplayCommandOptions& options);

}  // namespace firn
