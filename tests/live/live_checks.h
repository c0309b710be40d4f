// Checks the conditions that must hold after live prints.
#pragma once

#include <string>

#include "runtime/run_clock.h"
#include "tests/live/live_run.h"

namespace firn::test {

/// Says so and returns true where multicast is refused.
bool skipped();

/// By the world's own record: nothing fires, no lamp is open and no arm moves later than 1 s of wall time
/// after `mono_ns`.
void check_safe_after(const LiveRun& run, std::int64_t mono_ns);
/// By the world's record, in node time after `mono_ns`: the last shot and the end of the last exposure. [s]
double unsafe_for_s(const LiveRun& run, std::int64_t mono_ns);

/// Makes a folder with the programs of a print, one of them replaced by a script of the shell. @returns it
std::filesystem::path programs_with(const std::filesystem::path& folder, const std::string& name,
                                    const std::string& script);
/// The script that starts a program of the print unchanged, after `before`.
std::string starts(const std::string& name, const std::string& before);

/// Waits until the run has started and finished, LiveRun::wait_finished(). @returns its status; a failure
/// that follows reports the output of the run
int status_of(LiveRun& run);

/// Starts the print, kills `victim` from `earliest_us` to `latest_us` of wall time after its start, and
/// resumes: safe within a second, the cause named, finished, identical. @param witness node that says why it
/// stopped when the launcher was the victim
void kill_and_resume(const Experiment& experiment, const std::string& victim, const std::string& witness,
                     std::uint64_t seed, std::uint64_t earliest_us, std::uint64_t latest_us);

/// Replay identical, log whole, audit clean.
void check_finished_run(const LiveRun& run);

/// Cause of the last local stop in a node's write-ahead file; empty = none.
std::string local_stop_cause(const LiveRun& run, const std::string& node);

}  // namespace firn::test
