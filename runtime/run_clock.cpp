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

RunClock::RunClock(std::int64_t epoch_ns, std::int64_t offset_us, double scale)
    : scale_(scale), line_(std::make_shared<Line>()) {
  line_->from_ns = epoch_ns;
  line_->offset_us = offset_us;
  line_->rate = scale;
}

Time RunClock::at_ns(std::int64_t mono_ns) const {
  const std::lock_guard lock(line_->mutex);
  const std::int64_t since = mono_ns > line_->from_ns ? mono_ns - line_->from_ns : 0;
  return {std::int64_t(double(since) * line_->rate * 1e-3) + line_->offset_us};
}

std::int64_t RunClock::wall_us(Time t) const {
  if (t == Time::never()) return INT64_MAX;
  const std::lock_guard lock(line_->mutex);
  return line_->from_ns / 1000 + std::int64_t(double(t.us - line_->offset_us) / line_->rate) + 1;
}

void RunClock::follow(const ClockPoint& other, std::int64_t mono_ns) {
  const Time own = at_ns(mono_ns);
  const double theirs_us = double(other.node.us - own.us) + double(mono_ns - other.mono_ns) * scale_ * 1e-3;
  const double most = kMostSlew * scale_;
  const std::lock_guard lock(line_->mutex);
  line_->from_ns = mono_ns;
  line_->offset_us = own.us;
  line_->rate = scale_ + std::clamp(theirs_us * 1e-6 / kSlewS, -most, most);
}

}  // namespace firn
