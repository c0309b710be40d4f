// Measures how fast this machine reads the rows of a profiler, and fits the speed of the scans to it before a
// live print begins.
#pragma once

#include <functional>
#include <string>

#include "config/experiment.h"

namespace firn {

/// Wall time from a row's due time until a process at work on this machine has read it: the longest of some
/// hundred rows, which come in the period that the experiment asks for. Takes at most half a second.
double slowest_row_s(double period_s);

/// Returns the wall time between two rows of a scan. @param speed_mm_s of the scan
double row_period_s(const Experiment& experiment, double speed_mm_s);

/// Slows process.scan_speed_mm_s so that a row comes at most every `slowest_s` and a margin; a profiler keeps
/// only its newest row, so that rows which come faster are lost.
/// @param slowest_s of slowest_row_s()
/// @returns the changes, for the operator; empty: none
/// @throws UsageError naming process.scan_speed_mm_s, where less than an eighth of its speed would be left
std::string fit_scan_speed(Experiment& experiment, double slowest_s);

}  // namespace firn
