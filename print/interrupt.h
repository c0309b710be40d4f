// Ctrl-C as a question that a job asks itself between two steps, so that no temporary file stays.
#pragma once

#include <csignal>

namespace firn {

/// While it lives, SIGINT only raises a flag. One at a time.
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
