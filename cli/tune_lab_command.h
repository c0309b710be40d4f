// run_tune_lab computes the settings of configuration keys that print best in the laboratory that a log comes
// from, and the improvement that they promise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/study_options.h"

namespace firn {

class OptionSet;

struct TuneLabOptions {
  std::vector<std::string> runs;
  std::vector<std::string> keys;       ///< "control.smf.kp" or "control.smf.kp=0.2:2"
  std::vector<std::string> overrides;  ///< of the recorded experiment, for the prints that are tuned
  std::string goal = "rms";
  int budget = 420;   ///< simulated prints, about
  int verify = 0;     ///< pairs of prints with old and new setting; 0 = none
  int promised = 10;  ///< without verify: the promise is about the mean of so many prints
  std::uint64_t seed = 1;
  std::string state;   ///< file of simulated prints; empty = none
  std::string output;  ///< page; empty = none
  StudyOptions study;  ///< of verify's prints
  bool unsealed = false;
  bool run_python = false;  ///< of a run of another user or host
};

/// @returns kOk with advice or with nothing to gain, kFailed where the laboratory is of no known class or a
/// verified promise did not hold
/// @throws UsageError naming run, key or limit
int run_tune_lab(const TuneLabOptions& options);

/// Declares the arguments.
void declare_tune_lab(OptionSet& options);

}  // namespace firn
