// Prints the cylinder on the independent plant under every scheme: RMS, mean and std of the true final
// surface about the target, mean over seeds with 95 % BCa bootstrap intervals. `firn compare` reports if they
// differ.
//   cylinder_schemes [--seeds N] [--experiment FILE] [--json]
#include <fmt/core.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/include.h"
#include "core/statistics/bootstrap.h"
#include "print/labs/print_labs.h"
#include "print/simulated/memory_print.h"

namespace {

using namespace firn;

struct Interval {
  double mean, low, high;
};

Interval bootstrap(const std::vector<double>& x) {
  const statistics::Interval i = statistics::bootstrap_interval(x);
  return {statistics::mean(x), i.low, i.high};
}

}  // namespace

int main(int argc, char** argv) {
  int seeds = 10;
  bool json = false;
  std::string experiment = FIRN_SOURCE_DIR "/experiments/cylinder.toml";
  for (int n = 1; n < argc; ++n) {
    const std::string a = argv[n];
    if (a == "--json") json = true;
    if (a == "--seeds" && n + 1 < argc) seeds = std::atoi(argv[++n]);
    if (a == "--experiment" && n + 1 < argc) experiment = argv[++n];
  }
  nlohmann::ordered_json table = nlohmann::json::array();
  if (!json)
    fmt::print("{} seeds, {}\n{:<10} {:>7} {:>9}   {:<26} {:<26} {:<26}\n", seeds, experiment, "scheme",
               "layers", "droplets", "RMS [um]", "mean error [um]", "std [um]");
  for (const char* scheme : {"open_loop", "threshold", "smf", "mpc"}) {
    std::vector<double> rms, mean, std_dev, layers, drops;
    for (int seed = 1; seed <= seeds; ++seed) {
      const Experiment e = load_experiment(
          experiment, {std::string("control.scheme=") + scheme, "plant.seed=" + std::to_string(seed)});
      const Blobs inputs = make_inputs(e, std::filesystem::path(experiment).parent_path());
      const MemoryPrintReport report = print_in_memory(e, inputs);
      if (report.result.status != 0) {
        fmt::print(stderr, "{} seed {}: {}\n", scheme, seed, report.result.reason);
        return 1;
      }
      rms.push_back(report.error.rms_mm * 1e3);
      mean.push_back(report.error.mean_mm * 1e3);
      std_dev.push_back(report.error.std_mm * 1e3);
      layers.push_back(report.result.layers);
      drops.push_back(double(report.droplets));
    }
    const Interval r = bootstrap(rms), m = bootstrap(mean), d = bootstrap(std_dev);
    if (json) {
      const auto j = [](const Interval& i) {
        return nlohmann::ordered_json{{"mean", i.mean}, {"low", i.low}, {"high", i.high}};
      };
      table.push_back({{"scheme", scheme},
                       {"layers", bootstrap(layers).mean},
                       {"droplets", bootstrap(drops).mean},
                       {"rms_um", j(r)},
                       {"mean_error_um", j(m)},
                       {"std_um", j(d)}});
    } else {
      const auto t = [](const Interval& i) {
        return fmt::format("{:.2f} [{:.2f}, {:.2f}]", i.mean, i.low, i.high);
      };
      fmt::print("{:<10} {:>7.1f} {:>9.0f}   {:<26} {:<26} {:<26}\n", scheme, bootstrap(layers).mean,
                 bootstrap(drops).mean, t(r), t(m), t(d));
      std::fflush(stdout);
    }
  }
  if (json) fmt::print("{}\n", table.dump(2));
  return 0;
}
