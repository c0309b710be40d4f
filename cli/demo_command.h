// `firn demo`: prints a cylinder live under each scheme, replays every run bit for bit, writes one report.
#pragma once

#include <string>
#include <vector>

namespace firn {

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

}  // namespace firn
