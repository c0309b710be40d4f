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

/// Holds the result of ten half-filled layers on the plant "lu2015" with planted h1..h3 and droplets (1 + v
/// U[0,1]) times as large.
struct PlantedTrial {
  double truth_mm[4] = {}, ours_mm[4] = {}, sigma_mm[4] = {};  ///< h1, h2, h3, h1 + 4 h2 + 4 h3
  double error(int n) const { return ours_mm[n] / truth_mm[n] - 1.0; }
  double z(int n) const { return (ours_mm[n] - truth_mm[n]) / sigma_mm[n]; }
};
/// @param file experiments/excitation.toml
PlantedTrial planted_trial(const std::string& file, std::uint64_t seed, double variation);

struct PlantedTotals {
  int trials = 0;
  double worst_error[4] = {};  ///< |error|
  double mean_z[4] = {};       ///< 0 where there is no bias
  double worst_z = 0.0;        ///< |z| of all four
  int within_3_sigma[4] = {}, covered[4] = {};
};
PlantedTotals totals_of(const std::vector<PlantedTrial>& trials);

/// Runs job(0) .. job(count - 1) on the given number of threads. The first exception is thrown again.
void run_jobs(int count, int threads, const std::function<void(int)>& job);

}  // namespace firn
