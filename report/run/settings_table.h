// settings_table() shows the settings in which several runs differ; runs of two labs differ in dozens.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_page.h"

namespace firn::report {

/// Returns a table with a column for each name. Of many settings, those of part, lab and scheme and the first
/// of the others are shown; the rest is folded away below.
std::string settings_table(const std::vector<DifferingParameter>& parameters,
                           const std::vector<std::string>& names);

}  // namespace firn::report
