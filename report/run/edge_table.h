// edge_table() writes the table of a report that shows how well each part keeps within its outline.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_page.h"

namespace firn::report {

/// A row for the last measured map of each run and one for its last true surface, if a simulated world told
/// it; the columns are kOutlineMetrics, print time, passes and droplets. "" where no run has either.
/// @param names of the runs, in their order
std::string edge_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names);

}  // namespace firn::report
