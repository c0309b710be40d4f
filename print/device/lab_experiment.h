// load_lab_experiment loads the experiment of a lab's file alone.
#pragma once

#include <string>
#include <vector>

#include "config/experiment.h"

namespace firn {

/// As load_experiment; a lab's file names no part, which an ice lab's experiment must. @throws ConfigError
Experiment load_lab_experiment(const std::string& file, const std::vector<std::string>& overrides);

}  // namespace firn
