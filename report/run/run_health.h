// RunHealth holds the events of a run that a reader must know before its errors: stops, resumes, doubts,
// faults and lost rows, and the verdicts of tolerance and audit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runs/read/run_messages.h"

namespace firn::report {

struct ReportRun;

struct RunHealth {
  int stops = 0;  ///< ends of a run that could go on
  int resumes = 0;
  int doubts = 0;    ///< passes or paths whose outcome is not known
  int warnings = 0;  ///< faults that did not stop the print
  int faults = 0;    ///< and those that did
  std::int64_t rows_lost = 0;
};

RunHealth health_of(const runs::RunMessages& messages);

/// Returns a table of one row for each run. @param names of the runs
std::string health_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names);

}  // namespace firn::report
