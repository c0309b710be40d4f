// run_spy starts lcm-spy on a run's bus, with Firn's message types and views.
#pragma once

#include <string>

namespace firn {

class OptionSet;

struct SpyOptions {
  std::string run;  ///< run folder; empty = the newest print that goes on in `runs`
  std::string runs = "runs";
  std::string bus;         ///< LCM URL instead of a run
  std::string screenshot;  ///< PNG of the whole screen, then the end; without a display a virtual one is used
  int layers = 3;          ///< seen before the screenshot
};
/// @throws UsageError: no such run, a run that has ended or was printed in one process, no display, a missing
/// package.
/// @returns the exit code of lcm-spy.
int run_spy(const SpyOptions& options);

/// Declares the arguments.
void declare_spy(OptionSet& options);

}  // namespace firn
