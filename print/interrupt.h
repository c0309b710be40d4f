// InterruptGuard turns Ctrl-C, SIGTERM and the end of the terminal into a flag that a job reads between two
// steps, so that no temporary file stays.
#pragma once

#include <array>
#include <csignal>

namespace firn {

/// During the guard's lifetime, these signals only raise a flag. At most one guard may exist.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool raised();

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace firn
