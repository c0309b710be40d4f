// Reads a recorded run for the report, with the functions of its lab's row (print/labs/print_labs.h).
#pragma once

#include <filesystem>

#include "report/run/report_data.h"

namespace firn {

/// A run whose configuration cannot be read counts as one of the default lab.
/// @throws std::invalid_argument, logfile::FileError, FormatError: as replay::read_run_data
replay::RunData run_data(const std::filesystem::path& run);

}  // namespace firn
