// CPU time of one whole in-process print: all nodes, the world, write-ahead files and log.
//   lab_cpu [EXPERIMENT] [--runs N] [--set KEY=VALUE]…
#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "tests/bench/bench.h"

namespace firn::bench::lab_cpu {

namespace {

double cpu_s(bool user) {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  const timeval& t = user ? u.ru_utime : u.ru_stime;
  return double(t.tv_sec) + double(t.tv_usec) * 1e-6;
}

}  // namespace

FIRN_BENCH(lab_cpu) {
  using namespace firn;
  std::string file = FIRN_SOURCE_DIR "/experiments/cylinder.toml";
  std::vector<std::string> overrides;
  int runs = 5;
  for (int n = 1; n < argc; ++n) {
    const std::string a = argv[n];
    if (a == "--runs" && n + 1 < argc)
      runs = std::atoi(argv[++n]);
    else if (a == "--set" && n + 1 < argc)
      overrides.push_back(argv[++n]);
    else
      file = a;
  }
  const Experiment e = load_experiment(file, overrides);
  const Blobs inputs = make_inputs(full_product(), e, std::filesystem::path(file).parent_path());
  const std::filesystem::path root =
      std::filesystem::temp_directory_path() / fmt::format("firn-lab-cpu-{}", getpid());
  std::vector<double> user, system;
  for (int n = 0; n < runs; ++n) {
    const runs::RunFolder run = runs::RunFolder::create(root, e, inputs, {"lab_cpu"});
    const double u = cpu_s(true), s = cpu_s(false);
    const LabRunReport r = run_in_lab(full_product(), run, {});
    user.push_back(cpu_s(true) - u);
    system.push_back(cpu_s(false) - s);
    fmt::print(
        "{}: {} layers, {} steps, {} messages, {:.1f} MB, {:.1f} s node time, handlers {:.3f} s, user {:.3f} "
        "s, system {:.3f} s\n",
        r.result.outcome, r.result.layers, r.steps, r.messages, double(r.message_bytes) * 1e-6,
        r.node_seconds, r.handler_seconds, user.back(), system.back());
    std::filesystem::remove_all(run.path());
  }
  std::filesystem::remove_all(root);
  std::sort(user.begin(), user.end());
  std::sort(system.begin(), system.end());
  fmt::print("median of {} runs: user {:.3f} s, system {:.3f} s\n", runs, user[user.size() / 2],
             system[system.size() / 2]);
  return 0;
}

}  // namespace firn::bench::lab_cpu
