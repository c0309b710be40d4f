// check_experiment checks the rules between fields: the part must fit the grid, the grid the stage, the
// speeds the instruments.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "config/error.h"
#include "config/experiment.h"

namespace firn {

struct Origin {
  std::string file;
  int line = 0;
};
/// File and line that set each key; keys at their defaults are absent.
using Origins = std::map<std::string, Origin>;

/// @throws ConfigError at the first rule that is broken, naming the key set last among those concerned, its
/// value and the limit. The error names `file` if all keys concerned have their defaults.
/// @param whole instruments that a trigger line couples must be of one kind: all real, or all simulated
/// @param all gets an error for every rule that is broken instead; null: the first is thrown
void check_experiment(const Experiment& experiment, const Origins& origins, const std::string& file,
                      bool whole, std::vector<ConfigError>* all = nullptr);

}  // namespace firn
