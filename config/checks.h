// What no single field can tell: whether the part fits the grid, the grid the stage, the speeds the
// instruments.
#pragma once

#include <map>
#include <string>

#include "config/experiment.h"

namespace firn {

struct Origin {
  std::string file;
  int line = 0;
};
/// Where each key that is not at its default was set.
using Origins = std::map<std::string, Origin>;

/// @throws ConfigError at the first rule that is broken, naming the key set last among those concerned, its
/// value and the limit. `file` is named where all keys concerned stand at their defaults.
void check_experiment(const Experiment& experiment, const Origins& origins, const std::string& file);

}  // namespace firn
