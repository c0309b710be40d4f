// Writes one self-contained HTML page for any number of runs: no network, no script; light and dark.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_data.h"

namespace firn::report {

struct ReportRun {
  RunData data;
  std::string verdict;     ///< of replay: "identical", "differs"; empty = not replayed
  std::string audit = {};  ///< "clean", or the number of violations and the first; empty = not audited
};

/// Holds a setting that is not the same in all runs.
struct DifferingParameter {
  std::string key, unit;
  std::vector<std::string> values;  ///< by run
};

std::string report_page(const std::vector<ReportRun>& runs,
                        const std::vector<DifferingParameter>& parameters);

}  // namespace firn::report
