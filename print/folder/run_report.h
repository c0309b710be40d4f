// Reads a recorded run for the report, with the functions of its lab's row (print/labs/print_lab.h).
#pragma once

#include <filesystem>

#include "print/labs/product.h"
#include "report/run/report_data.h"

namespace firn {

/// A run whose configuration cannot be read counts as one of the default lab.
/// @throws UsageError: no run folder; std::invalid_argument, record::FileError, FormatError: as
/// report::read_run_data
report::RunData run_data(const Product& product, const std::filesystem::path& run);

}  // namespace firn
