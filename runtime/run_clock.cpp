#include "runtime/run_clock.h"

#include <algorithm>
#include <ctime>

namespace firn {

std::int64_t monotonic_ns() {
  timespec t;
  clock_gettime(CLOCK_BOOTTIME, &t);
  return std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

timespec poll_timeout(std::int64_t us) {
  us = std::clamp<std::int64_t>(us, 0, kLongestPollUs);
  return {time_t(us / 1'000'000), long(us % 1'000'000) * 1000};
}

}  // namespace firn
