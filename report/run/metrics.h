// Writes metrics.csv of a run: one row a layer.
#pragma once

#include <string>

#include "report/run/report_data.h"

namespace firn::report {

/// Returns header and rows. Heights and errors in um, as printed beside the papers' tables; the true_ columns
/// are empty if no simulated world reported the truth.
std::string metrics_csv(const RunData& run);

}  // namespace firn::report
