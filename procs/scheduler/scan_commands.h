// Fills in the commands of one swath of a scan over the grid, for stage and profiler. Ids and layer are the
// scheduler's.
#pragma once

#include "config/experiment.h"
#include "firn/enums.h"
#include "firn/profiler_command_t.hpp"
#include "firn/stage_command_t.hpp"

namespace firn {

struct Swath {
  std::int64_t scan_id = 0;
  int attempt = 0;
  std::size_t number = 0, count = 1;
  double shift_mm = 0.0;  ///< of the stage from the grid's middle
};

stage_command_t scan_command(const Experiment& e, const Swath& swath, double speed_mm_s);
profiler_command_t profiler_command(const Experiment& e, const Swath& swath, ProfilerVerb verb);
/// Longest time that the stage may take for a scan_command().
double scan_time_s(const Experiment& e, double speed_mm_s);

}  // namespace firn
