// Starts a print in a process that no terminal ends.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace firn {

struct DetachedPrint {
  pid_t pid = 0;
};

/// Starts this program with `words` in a session of its own, its output in RUN/print.out, and waits until the
/// print takes the operator's orders.
/// @throws std::runtime_error with the last line of the output if it ends before that
DetachedPrint start_detached(const std::filesystem::path& run, const std::vector<std::string>& words);

}  // namespace firn
