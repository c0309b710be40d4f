// run_demo prints a cylinder under each scheme, replays every run and writes one report.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct DemoOptions {
  std::string bus;  ///< as PrintOptions
  std::string runs = "runs";
  std::string output;                  ///< of the report; "" = report.html in the last run's folder
  std::vector<std::string> overrides;  ///< --set KEY=VALUE, for every scheme
  bool json = false;
};

/// @returns 0 if every print finished and every run replays identical, 1 if one does not, 3 after a safety
/// stop
int run_demo(const DemoOptions& options);

/// Declares the arguments.
void declare_demo(OptionSet& options);

}  // namespace firn
