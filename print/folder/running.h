// Finds the process that prints a run now.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>

namespace firn {

/// Returns the process that prints `run`; nothing if nobody does.
std::optional<pid_t> printing_process(const std::filesystem::path& run);

/// @throws UsageError "RUN is running (pid 1234)" while somebody prints the run
void refuse_running(const std::filesystem::path& run);

}  // namespace firn
