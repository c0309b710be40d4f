#include "cli/study_lab.h"

#include <time.h>

#include <cmath>
#include <exception>
#include <limits>
#include <new>

#include "cli/memory_print.h"
#include "cli/print_command.h"

namespace firn {
namespace {

constexpr double kUm = 1e3;  // per mm

double thread_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

const std::vector<replay::StudyMetric>& metric_table() {
  static const std::vector<replay::StudyMetric> table = {
      {"rms_um", "um", "RMS of the true surface about the target", 2},
      {"std_um", "um", "roughness: standard deviation of the true error about its mean", 2},
      {"abs_mean_um", "um", "size of the mean error of the true surface", 2},
      {"mean_abs_um", "um", "mean of the absolute true error", 2},
      {"max_um", "um", "largest absolute true error of a cell", 2},
      {"layers", "", "layers printed", 1},
      {"droplets", "", "droplets fired", 0},
      {"print_s", "s", "simulated duration of the print", 1},
      {"iterations", "", "steps of the controller's search", 0},
  };
  return table;
}

std::vector<double> metrics_of(const MemoryPrintReport& r) {
  const ErrorStats& e = r.error;
  if (e.cells == 0) return std::vector<double>(metric_table().size(), std::numeric_limits<double>::quiet_NaN());
  return {e.rms_mm * kUm, e.std_mm * kUm, std::abs(e.mean_mm) * kUm, e.mean_abs_mm * kUm,
          std::max(std::abs(e.min_mm), std::abs(e.max_mm)) * kUm, double(r.result.layers), double(r.droplets), r.node_s,
          double(r.iterations)};
}

void seed_all(Experiment& e, std::uint64_t seed) {
  e.plant.seed = seed;
  e.control.mpc.seed = seed;
}

StudyPrint print_once(const Experiment& e, const Blobs& inputs) {
  StudyPrint p;
  const double began = thread_cpu_s();
  try {
    const MemoryPrintReport r = print_in_memory(e, inputs);
    p.finished = r.result.status == 0;
    p.outcome = r.result.outcome;
    p.reason = r.result.reason;
    p.metrics = metrics_of(r);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    p.outcome = "error";
    p.reason = error.what();
    p.metrics.assign(metric_table().size(), std::numeric_limits<double>::quiet_NaN());
  }
  p.cpu_s = thread_cpu_s() - began;
  return p;
}

}  // namespace

const StudyLab& inkjet_study_lab() {
  static const StudyLab lab{metric_table(), {"rms_um", "std_um", "abs_mean_um", "layers", "droplets"}, &seed_all,
                            [](const Experiment& e) { check_print(e, "in-process"); }, &print_once};
  return lab;
}

}  // namespace firn
