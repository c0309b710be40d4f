// Cost of replay beside the cost of the handlers that it runs again, on a print that the Lab has just made.
//   replay_bench [EXPERIMENT] [--rounds N] [--set KEY=VALUE]…
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/replay_command.h"
#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/print_verdict.h"
#include "tests/bench/bench.h"

namespace firn::bench::replay_bench {

namespace {

std::uint64_t bytes_in(const std::filesystem::path& folder) {
  std::uint64_t sum = 0;
  for (const auto& f : std::filesystem::recursive_directory_iterator(folder))
    if (f.is_regular_file()) sum += f.file_size();
  return sum;
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

}  // namespace

FIRN_BENCH(replay_bench) {
  using namespace firn;
  std::string file = FIRN_SOURCE_DIR "/experiments/cylinder.toml";
  std::vector<std::string> overrides;
  int rounds = 9;
  for (int n = 1; n < argc; ++n) {
    const std::string a = argv[n];
    if (a == "--rounds" && n + 1 < argc)
      rounds = std::atoi(argv[++n]);
    else if (a == "--set" && n + 1 < argc)
      overrides.push_back(argv[++n]);
    else
      file = a;
  }
  const Experiment e = load_experiment(file, overrides);
  const auto root = std::filesystem::temp_directory_path() / fmt::format("firn-replay-bench-{}", getpid());
  const runs::RunFolder run = runs::RunFolder::create(
      root, e, make_inputs(full_product(), e, std::filesystem::path(file).parent_path()), {"replay_bench"});
  const LabRunReport lab = run_in_lab(full_product(), run, {});
  const double mb =
      double(bytes_in(run.path() / "nodes") + std::filesystem::file_size(run.log_path())) * 1e-6;
  fmt::print("{} after {} layers, {:.1f} s of node time, {:.1f} MB of write-ahead files and log\n",
             lab.result.outcome, lab.result.layers, lab.node_seconds, mb);
  int status = 0;
  for (const int threads : {1, 0}) {
    std::vector<double> walls, handlers;
    std::uint64_t messages = 0;
    for (int n = 0; n < rounds; ++n) {
      ReplayCommandOptions o;
      o.run = run.path().string();
      o.threads = threads;
      const replay::RunVerdict v = replay_verdict(full_product(), o);
      if (!v.identical()) {
        fmt::print("{}", replay::to_text(v));
        status = 1;
      }
      walls.push_back(double(v.wall_ns) * 1e-9);
      messages = v.log_messages;
      for (const auto& node : v.nodes) messages += node.messages + node.events_in;
      // The handlers alone, by one thread, so that they do not wait for each other.
      o.threads = 1;
      o.stopwatch = true;
      double handler_s = 0;
      for (const auto& node : replay_verdict(full_product(), o).nodes)
        handler_s += double(node.handler_ns) * 1e-9;
      handlers.push_back(handler_s);
    }
    const double wall_s = median(walls), handler_s = median(handlers);
    fmt::print(
        "{}: wall {:.4f} s, handlers {:.4f} s (recorded {:.4f} s), ratio {:.2f}; {:.0f} messages/s, {:.0f} "
        "MB/s, {:.0f} x real time\n",
        threads == 1 ? "one thread " : "all threads", wall_s, handler_s, lab.handler_seconds,
        wall_s / handler_s, double(messages) / wall_s, mb / wall_s, lab.node_seconds / wall_s);
  }
  std::filesystem::remove_all(root);
  return status;
}

}  // namespace firn::bench::replay_bench
