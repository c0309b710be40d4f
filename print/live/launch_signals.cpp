#include "print/live/launch_signals.h"

#include <iterator>

namespace firn {
namespace {

constexpr std::size_t kCounted = 3;  // the first of kHandled
volatile sig_atomic_t interruptions = 0;

}  // namespace

LaunchSignals::LaunchSignals() {
  interruptions = 0;
  for (std::size_t n = 0; n < std::size(kHandled); ++n) {
    struct sigaction a {};
    if (n < kCounted)
      a.sa_handler = [](int) { interruptions = interruptions + 1; };
    else
      a.sa_handler = SIG_IGN;
    ::sigaction(kHandled[n], &a, &before_[n]);
  }
}

LaunchSignals::~LaunchSignals() {
  for (std::size_t n = 0; n < std::size(kHandled); ++n) ::sigaction(kHandled[n], &before_[n], nullptr);
}

int LaunchSignals::interrupted() const { return int(interruptions); }

}  // namespace firn
