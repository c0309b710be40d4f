// RunClock computes node time from CLOCK_BOOTTIME, the same in every process of a run. It goes on while the
// computer sleeps, so that a lease ends meanwhile. On another host of the run it follows the launcher's.
#pragma once

#include <time.h>

#include <cstdint>
#include <memory>
#include <mutex>

#include "runtime/time.h"

namespace firn {

std::int64_t monotonic_ns();
inline std::int64_t monotonic_us() { return monotonic_ns() / 1000; }

/// No process waits longer without a look at the time: poll's own clock stands still while the computer
/// sleeps.
inline constexpr std::int64_t kLongestPollUs = 1'000'000;
/// Returns a wait as ppoll() takes it, of at most kLongestPollUs; 0 for one that is over.
timespec poll_timeout(std::int64_t us);

/// Node time of another clock: `node` at `mono_ns` of this computer's CLOCK_BOOTTIME, and as fast as it.
struct ClockPoint {
  std::int64_t mono_ns = 0;
  Time node;
};

/// Node time = (monotonic - epoch) * scale + offset. After a resume the offset is behind everything that was
/// recorded. Copies go together: all follow the clock that one follows.
class RunClock {
 public:
  RunClock(std::int64_t epoch_ns, std::int64_t offset_us, double scale);
  Time now() const { return at_ns(monotonic_ns()); }
  Time at_ns(std::int64_t mono_ns) const;
  /// Wall microseconds (CLOCK_BOOTTIME) at which node time reaches `t`, rounded up.
  std::int64_t wall_us(Time t) const;

  /// Follows another clock from `mono_ns` on: without a step and never backwards, at most kMostSlew faster or
  /// slower than this computer's, so that a difference is gone after kSlewS where it may be.
  void follow(const ClockPoint& other, std::int64_t mono_ns);
  static constexpr double kMostSlew = 1e-3;  ///< a crystal is within 200 ppm
  static constexpr double kSlewS = 1.0;

 private:
  struct Line {  // node time = (mono - from) * rate * 1e-3 + offset
    std::mutex mutex;
    std::int64_t from_ns, offset_us;
    double rate;
  };
  double scale_;
  std::shared_ptr<Line> line_;
};

}  // namespace firn
