// Settings that are not the same in all of several experiments: what a report and a study show of them.
#pragma once

#include <vector>

#include "config/experiment.h"
#include "report/run/report_page.h"

namespace firn {

/// Rows in the order of the configuration table, each with the value of every experiment.
std::vector<replay::DifferingParameter> differing_parameters(std::vector<Experiment> experiments);

}  // namespace firn
