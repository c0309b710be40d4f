// run_preview shows a print before it begins: part, cost, and misfits.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct PreviewOptions {
  std::string experiment;
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  std::string output;                  ///< SVG; "" = no picture
  bool json = false;
};

/// @returns 0, or 1 where the print would be refused
int run_preview(const PreviewOptions& options);

/// Declares the arguments.
void declare_preview(OptionSet& options);

}  // namespace firn
