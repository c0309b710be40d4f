// print_use sums the use of a print: ink, and the hours of its instruments.
#pragma once

#include <filesystem>
#include <optional>

#include "runs/folder/documents.h"

namespace firn::runs {

/// Reads it from the run's log, or from its scheduler's write-ahead file where the log is not whole. Nothing
/// of a run that cannot be read or in which no instrument took part.
std::optional<PrintUse> print_use(const std::filesystem::path& run);

}  // namespace firn::runs
