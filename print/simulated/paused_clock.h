// PausedClock holds the simulated time of a paused print back to the speed of a live one.
#pragma once

#include <chrono>
#include <optional>
#include <utility>

#include "runtime/time.h"

namespace firn {

class PausedClock {
 public:
  /// @param time_scale node seconds per wall second
  explicit PausedClock(double time_scale) : time_scale_(time_scale) {}

  bool running() const { return since_.has_value(); }
  void begin(Time now) {
    if (!since_) since_.emplace(now, std::chrono::steady_clock::now());
  }
  void end() { since_.reset(); }
  /// Returns the wall time [s] by which `now` comes too early; 0 or less: it does not.
  double ahead_s(Time now) const {
    if (!since_) return 0.0;
    const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - since_->second;
    return seconds_between(since_->first, now) / time_scale_ - waited.count();
  }

 private:
  double time_scale_;
  std::optional<std::pair<Time, std::chrono::steady_clock::time_point>> since_;
};

}  // namespace firn
