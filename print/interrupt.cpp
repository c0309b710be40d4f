#include "print/interrupt.h"

namespace firn {
namespace {

volatile std::sig_atomic_t interrupt_raised = 0;

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupt_raised = 0;
  struct sigaction a {};
  a.sa_handler = [](int) { interrupt_raised = 1; };
  for (std::size_t n = 0; n < kSignals.size(); ++n) ::sigaction(kSignals[n], &a, &before_[n]);
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t n = 0; n < kSignals.size(); ++n) ::sigaction(kSignals[n], &before_[n], nullptr);
}

bool InterruptGuard::raised() { return interrupt_raised != 0; }

}  // namespace firn
