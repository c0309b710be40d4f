// ClockError holds how far the clocks of a process with the preloaded library other_clock are off.
#pragma once

#include <cstdint>

namespace firn::test {

/// The file FIRN_CLOCK_FILE has these bytes.
struct ClockError {
  std::int64_t wall_ns = 0;    ///< CLOCK_REALTIME
  std::int64_t leap_ns = 0;    ///< CLOCK_MONOTONIC and CLOCK_BOOTTIME
  std::int64_t drift_ppm = 0;  ///< CLOCK_BOOTTIME, from the start of the process
};

}  // namespace firn::test
