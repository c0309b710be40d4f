// InterruptGuard turns Ctrl-C into a flag that a job reads between two steps, so that no temporary file
// stays.
#pragma once

#include <csignal>

namespace firn {

/// During the guard's lifetime, SIGINT only raises a flag. At most one guard may exist.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool raised();

 private:
  struct sigaction before_ {};
};

}  // namespace firn
