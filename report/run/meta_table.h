// meta_table() writes the part of a report that says what was printed: [meta], tags and notes of each run.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_page.h"

namespace firn::report {

/// Returns "" if no run has any of these. @param names of the runs, in their order
std::string meta_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names);

}  // namespace firn::report
