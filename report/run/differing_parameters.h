// Computes the settings that are not the same in all of several experiments, for a report and a study.
#pragma once

#include <vector>

#include "config/experiment.h"
#include "report/run/report_page.h"

namespace firn::report {

/// Returns rows in the order of the configuration table, each with the value of every experiment.
std::vector<report::DifferingParameter> differing_parameters(std::vector<Experiment> experiments);

}  // namespace firn::report
