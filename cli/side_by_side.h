// print_side_by_side() carries out live prints at once, each in a process of its own.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/print_run.h"

namespace firn {

struct LivePrint {
  std::string title;  ///< begins the lines about its failure
  std::function<PrintSummary()> carry_out;
};

/// Starts all prints, passes on their stderr line by line, and waits for their ends. Ctrl-C,
/// SIGTERM and the end of this process make their labs safe. Of a summary come back: folder, scheme, result,
/// droplets, wall time.
/// @throws std::runtime_error naming the print that ended without a summary
std::vector<PrintSummary> print_side_by_side(const std::vector<LivePrint>& prints);

}  // namespace firn
