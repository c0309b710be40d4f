// Finds the process that prints a run now.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>

namespace firn::runs {

/// Returns the process that prints `run`, or whose drivers still make its lab safe; nothing if nobody does,
/// or the locks of the run are another user's.
std::optional<pid_t> printing_process(const std::filesystem::path& run);

/// Returns the launcher whose processes hold the instruments in RUN/io; it may have died. Nothing if nobody
/// holds them, and for a link to instruments that other runs share.
std::optional<pid_t> launcher_of_instruments(const std::filesystem::path& run);

}  // namespace firn::runs
