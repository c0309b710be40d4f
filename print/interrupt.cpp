#include "print/interrupt.h"

namespace firn {
namespace {

volatile std::sig_atomic_t interrupted = 0;

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted = 0;
  struct sigaction a {};
  a.sa_handler = [](int) { interrupted = 1; };
  ::sigaction(SIGINT, &a, &before_);
}

InterruptGuard::~InterruptGuard() { ::sigaction(SIGINT, &before_, nullptr); }

bool InterruptGuard::raised() { return interrupted != 0; }

}  // namespace firn
