#include "studies/identify/identification_study.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "config/include.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "print/labs/print_labs.h"
#include "print/simulated/memory_print.h"

namespace firn {

ObservedRun observe_print(const std::string& file, const std::vector<std::string>& overrides) {
  const Experiment e = load_experiment(file, overrides);
  const Blobs inputs = make_inputs(e, std::filesystem::path(file).parent_path());
  ObservedRun run(e, mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask"));
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> message) {
    run.take(channel, message);
  };
  const MemoryPrintReport report = print_in_memory(e, inputs, options);
  if (report.result.status != 0)
    throw std::runtime_error(file + ": the print did not finish: " + report.result.reason);
  return run;
}

PlantedTrial planted_trial(const std::string& file, std::uint64_t seed, double variation) {
  const std::string s = std::to_string(seed);
  // The plant prints with Table I; the prior values lie up to 20 % off, differently for every seed.
  const auto off = [&](std::uint32_t n) {
    return 0.8 + 0.4 * random_uniform({seed, Purpose::kInstance, 0, 0, n});
  };
  const ObservedRun run =
      observe_print(file, {"plant.model=lu2015", "plant.seed=" + s, "control.pattern.seed=" + s,
                           "plant.variation=" + std::to_string(variation), "estimator.droplets=off",
                           "model.h1_mm=" + std::to_string(0.0044 * off(0)),
                           "model.h2_mm=" + std::to_string(0.0006 * off(1)),
                           "model.h3_mm=" + std::to_string(0.0002 * off(2))});
  const droplet::Estimate e = run.learn();
  const double mean = 1.0 + 0.5 * variation;
  const deposition::DropletModel planted{0.0044 * mean, 0.0006 * mean, 0.0002 * mean};
  return {{planted.h1_mm, planted.h2_mm, planted.h3_mm, planted.layer_height_mm()},
          {e.model.h1_mm, e.model.h2_mm, e.model.h3_mm, e.model.layer_height_mm()},
          {e.std_mm(0), e.std_mm(1), e.std_mm(2), e.layer_height_std_mm()}};
}

PlantedTotals totals_of(const std::vector<PlantedTrial>& trials) {
  PlantedTotals t;
  for (const PlantedTrial& trial : trials) {
    ++t.trials;
    for (int n = 0; n < 4; ++n) {
      const double z = std::abs(trial.z(n));
      t.mean_z[n] += trial.z(n) / double(trials.size());
      t.worst_error[n] = std::max(t.worst_error[n], std::abs(trial.error(n)));
      t.worst_z = std::max(t.worst_z, z);
      t.within_3_sigma[n] += z <= 3.0;
      t.covered[n] += z <= 1.959964;
    }
  }
  return t;
}

void run_jobs(int count, int threads, const std::function<void(int)>& job) {
  std::atomic<int> next{0};
  std::mutex lock;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int n; (n = next++) < count;) {
      try {
        job(n);
      } catch (...) {
        const std::lock_guard hold(lock);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  std::vector<std::jthread> helpers;
  for (int n = 1; n < std::min(threads, count); ++n) helpers.emplace_back(work);
  work();
  helpers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace firn
