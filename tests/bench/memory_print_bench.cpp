// Processor time of whole prints in memory (print/simulated/memory_print.h), after one print that warms up.
//   memory_print_bench [EXPERIMENT] [--runs N] [--set KEY=VALUE]…
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "tests/bench/bench.h"

namespace firn::bench::memory_print_bench {

namespace {

double seconds(const timeval& t) { return double(t.tv_sec) + double(t.tv_usec) * 1e-6; }

}  // namespace

FIRN_BENCH(memory_print_bench) {
  using namespace firn;
  std::string file = FIRN_SOURCE_DIR "/experiments/cylinder.toml";
  std::vector<std::string> overrides;
  int runs = 5;
  for (int n = 1; n < argc; ++n) {
    const std::string a = argv[n];
    if (a == "--runs" && n + 1 < argc)
      runs = std::max(1, std::atoi(argv[++n]));
    else if (a == "--set" && n + 1 < argc)
      overrides.push_back(argv[++n]);
    else
      file = a;
  }
  const Experiment e = load_experiment(file, overrides);
  const Blobs inputs = make_inputs(full_product(), e, std::filesystem::path(file).parent_path());
  print_in_memory(full_product(), e, inputs);
  std::vector<double> user, system;
  for (int n = 0; n < runs; ++n) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const MemoryPrintReport r = print_in_memory(full_product(), e, inputs);
    getrusage(RUSAGE_SELF, &after);
    user.push_back(seconds(after.ru_utime) - seconds(before.ru_utime));
    system.push_back(seconds(after.ru_stime) - seconds(before.ru_stime));
    fmt::print(
        "{}: {} layers, {} droplets, true RMS {:.3f} um, {:.1f} s node time, decisions {:.3f} s, user {:.3f} "
        "s, system {:.3f} s\n",
        r.result.outcome, r.result.layers, r.droplets, r.error.rms_mm * 1e3, r.node_s, r.decide_cpu_s,
        user.back(), system.back());
  }
  std::sort(user.begin(), user.end());
  std::sort(system.begin(), system.end());
  fmt::print("median of {} prints: user {:.3f} s, system {:.3f} s\n", runs, user[user.size() / 2],
             system[system.size() / 2]);
  return 0;
}

}  // namespace firn::bench::memory_print_bench
