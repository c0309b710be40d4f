// Print jobs of a shuttered printer on disk (docs/algorithms/aerosol.md).
#pragma once

#include <filesystem>

#include "core/path/print_job.h"

namespace firn {

/// *.json: {"start": [x, y], "end": [x, y], "segments": [{"from": [x, y], "to": [x, y], "speed_mm_s": v},
/// …]}; start and end may be left out: the first segment's begin and the last one's end.
/// *.csv: header x_mm,y_mm,speed_mm_s: connected segments through the points, each at the speed of the point
/// it leads to.
/// @throws UsageError naming file, key or line, and what is wrong
PrintJob read_print_job(const std::filesystem::path& file);

}  // namespace firn
