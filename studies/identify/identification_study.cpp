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
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"

namespace firn {

ObservedRun observe_print(const std::string& file, const std::vector<std::string>& overrides) {
  const Experiment e = load_experiment(file, overrides);
  const Blobs inputs = make_inputs(full_product(), e, std::filesystem::path(file).parent_path());
  ObservedRun run(e, mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask"));
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> message) {
    run.take(channel, message);
  };
  const MemoryPrintReport report = print_in_memory(full_product(), e, inputs, options);
  if (runs::can_go_on(report.result))
    throw std::runtime_error(file + ": the print did not finish: " + report.result.reason);
  return run;
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
