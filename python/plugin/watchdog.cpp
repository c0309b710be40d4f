#include "python/plugin/watchdog.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace firn::python {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kAgain{1};  // code that catches everything is told again

Clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

Watchdog::Watchdog(pybind11::object error) : error_(std::move(error)) {
  std::thread([this] { watch(); }).detach();
}

Watchdog::Token Watchdog::arm(double longest_s) {
  const std::lock_guard lock(mutex_);
  watches_.push_front({PyThread_get_thread_ident(), Clock::now() + duration_of(longest_s), false});
  changed_.notify_one();
  return watches_.begin();
}

bool Watchdog::disarm(Token watch) {
  const std::lock_guard lock(mutex_);
  const bool fired = watch->fired;
  if (fired) PyThreadState_SetAsyncExc(watch->thread, nullptr);
  watches_.erase(watch);
  return fired;
}

// The interpreter comes before the lock, as in arm and disarm.
void Watchdog::watch() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return !watches_.empty(); });
      const auto next = std::ranges::min(watches_, {}, &Watch::until).until;
      if (changed_.wait_until(lock, next) == std::cv_status::no_timeout) continue;
    }
    const PyGILState_STATE state = PyGILState_Ensure();
    {
      const std::lock_guard lock(mutex_);
      const auto now = Clock::now();
      for (Watch& w : watches_) {
        if (w.until > now) continue;
        PyThreadState_SetAsyncExc(w.thread, error_.ptr());
        w.fired = true;
        w.until = now + kAgain;
      }
    }
    PyGILState_Release(state);
  }
}

}  // namespace firn::python
