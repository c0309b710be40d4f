// run_view shows recorded and running prints in a browser.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct ViewOptions {
  std::vector<std::string> runs;  ///< run folders, and folders of run folders; none: "runs"
  std::string bind = "127.0.0.1";
  int port = 0;  ///< 0: the first free one
  std::vector<std::string> hosts;
  bool json = false;
};

/// Serves until Ctrl-C. @throws UsageError: no such folder, an address that is none, a port in use
int run_view(const ViewOptions& options);

/// Declares the arguments.
void declare_view(OptionSet& options);

}  // namespace firn
