// observe_print makes a print in memory for the identification of the model, for `firn reproduce lu`, the
// coverage bench and tests.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "print/folder/observed_run.h"

namespace firn {

/// Prints `file` with overrides ("key=value") and returns the lab's observations. @throws std::runtime_error
/// naming the reason when the print does not finish.
ObservedRun observe_print(const std::string& file, const std::vector<std::string>& overrides);

/// Runs job(0) .. job(count - 1) on the given number of threads. The first exception is thrown again.
void run_jobs(int count, int threads, const std::function<void(int)>& job);

}  // namespace firn
