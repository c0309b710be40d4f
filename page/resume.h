// Resumes a run for the page: `firn print --resume RUN --detach`, in a session of its own.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace firn::page {

/// Returns why the page does not resume a run: somebody prints it, it is over, or it has Python code of
/// another user or host; empty: it may.
std::string resume_refusal(const std::filesystem::path& run);

/// Starts the program and waits until the print takes orders. The print keeps neither files nor signals of
/// this process, and its priority is that of the calling thread.
/// @param program firn
/// @returns the process that prints; nothing: the print was over at once
/// @throws std::runtime_error with the last line that the program wrote
std::optional<pid_t> resume_detached(const std::filesystem::path& program, const std::filesystem::path& run);

/// Returns the program firn in the folder of this process's own program.
std::filesystem::path firn_beside();

}  // namespace firn::page
