// run_bounded runs a function in a child process with bounds on its time and memory, for libraries that
// hostile bytes can send into a hang or a crash.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace firn::mesh {

struct ChildLimits {
  int cpu_s = 5;                 ///< of processor time; the clock on the wall may run ten times as long
  std::size_t memory_bytes = 0;  ///< beyond those of this process at the call
};

/// Runs `send` in a forked child that writes to a pipe, and `receive` here on the pipe's other end.
/// @returns "" when the child has ended well, else how it ended: "took more than 5 s of processor time, the
/// limit". An exception of `receive` is handed on only if the child ended well, for a crash cuts its message.
/// @throws std::runtime_error: no process or pipe can be made
std::string run_bounded(const ChildLimits& limits, const std::function<void(int fd)>& send,
                        const std::function<void(int fd)>& receive);

}  // namespace firn::mesh
