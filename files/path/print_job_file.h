// read_print_job reads print jobs of a shuttered printer (docs/algorithms/aerosol.md).
#pragma once

#include <filesystem>

#include "core/path/print_job.h"

namespace firn {

/// *.json: {"start": [x, y], "end": [x, y], "segments": [{"from": [x, y], "to": [x, y], "speed_mm_s": v},
/// …]}; start and end are optional: the defaults are the first segment's begin and the last one's end.
/// *.csv: header x_mm,y_mm,speed_mm_s: connected segments through the points, each at the speed of its end
/// point.
/// @throws UsageError naming file, key or line, and the problem
PrintJob read_print_job(const std::filesystem::path& file);

}  // namespace firn
