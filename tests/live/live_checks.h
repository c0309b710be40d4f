// What must hold after live prints.
#pragma once

#include <string>

#include "runtime/run_clock.h"
#include "tests/live/live_run.h"

namespace firn::test {

/// Says so and returns true where multicast is refused.
bool skipped();

/// By the world's own record: nothing fires, no lamp is open and no arm moves later than 1 s of wall time after `mono_ns`.
void check_safe_after(const LiveRun& run, std::int64_t mono_ns);

/// Waits until the run has started and ended. @returns its status; what it said is told with a failure that follows
int status_of(LiveRun& run);

/// Replay identical, log whole, audit clean.
void check_finished_run(const LiveRun& run);

/// Cause of the last local stop in a node's write-ahead file; empty = none.
std::string local_stop_cause(const LiveRun& run, const std::string& node);

}  // namespace firn::test
