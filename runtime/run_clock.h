// RunClock computes node time from CLOCK_BOOTTIME, the same in every process of a run. It goes on while the
// computer sleeps, so that a lease ends meanwhile.
#pragma once

#include <time.h>

#include <cstdint>

#include "runtime/time.h"

namespace firn {

std::int64_t monotonic_ns();
inline std::int64_t monotonic_us() { return monotonic_ns() / 1000; }

/// No process waits longer without a look at the time: poll's own clock stands still while the computer
/// sleeps.
inline constexpr std::int64_t kLongestPollUs = 1'000'000;
/// Returns a wait as ppoll() takes it, of at most kLongestPollUs; 0 for one that is over.
timespec poll_timeout(std::int64_t us);

/// Node time = (monotonic - epoch) * scale + offset. After a resume the offset is behind everything that was
/// recorded.
class RunClock {
 public:
  RunClock(std::int64_t epoch_ns, std::int64_t offset_us, double scale)
      : epoch_ns_(epoch_ns), offset_us_(offset_us), scale_(scale) {}
  Time now() const { return at_ns(monotonic_ns()); }
  Time at_ns(std::int64_t mono_ns) const {
    const std::int64_t since = mono_ns > epoch_ns_ ? mono_ns - epoch_ns_ : 0;
    return {std::int64_t(double(since) * scale_ * 1e-3) + offset_us_};
  }
  /// Wall microseconds (CLOCK_BOOTTIME) at which node time reaches `t`, rounded up.
  std::int64_t wall_us(Time t) const {
    if (t == Time::never()) return INT64_MAX;
    return epoch_ns_ / 1000 + std::int64_t(double(t.us - offset_us_) / scale_) + 1;
  }

 private:
  std::int64_t epoch_ns_;
  std::int64_t offset_us_;
  double scale_;
};

}  // namespace firn
