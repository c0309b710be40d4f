// Measures the errors of h1, h2, h3 and of their intervals after ten random half-filled layers on the plant
// "lu2015", whose values are known: maximum error, errors within 3 sigma, share of seeds that the 95 %
// intervals cover.
//   estimator_coverage [--seeds N] [--variation V] [--experiment FILE] [--json]
#include <fmt/core.h>

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "files/json.h"
#include "tests/bench/bench.h"
#include "tests/support/planted_trial.h"

namespace firn::bench::estimator_coverage {

FIRN_BENCH(estimator_coverage) {
  using namespace firn;
  int seeds = 200;
  double variation = 0.2;
  bool json = false;
  std::string experiment = FIRN_SOURCE_DIR "/experiments/excitation.toml";
  for (int n = 1; n < argc; ++n) {
    const std::string a = argv[n];
    if (a == "--json") json = true;
    if (a == "--seeds" && n + 1 < argc) seeds = std::atoi(argv[++n]);
    if (a == "--experiment" && n + 1 < argc) experiment = argv[++n];
    if (a == "--variation" && n + 1 < argc) variation = std::atof(argv[++n]);
  }
  std::vector<PlantedTrial> trials(std::size_t(seeds > 0 ? seeds : 0));
  run_jobs(int(trials.size()), int(std::thread::hardware_concurrency()), [&](int n) {
    trials[std::size_t(n)] = planted_trial(experiment, std::uint64_t(n + 1), variation);
  });
  const PlantedTotals t = totals_of(trials);
  static constexpr const char* kNames[] = {"h1", "h2", "h3", "h1 + 4 h2 + 4 h3"};
  nlohmann::ordered_json rows = nlohmann::json::array();
  if (!json)
    fmt::print("{} seeds, variation {:g}\n{:<18} {:>16} {:>18} {:>16} {:>14}\n", seeds, variation, "",
               "worst error [%]", "within 3 sigma", "covered [%]", "mean z");
  for (int n = 0; n < 4; ++n) {
    if (json)
      rows.push_back({{"what", kNames[n]},
                      {"worst_error_percent", 100 * t.worst_error[n]},
                      {"within_3_sigma", t.within_3_sigma[n]},
                      {"covered", t.covered[n]},
                      {"mean_z", t.mean_z[n]},
                      {"seeds", t.trials}});
    else
      fmt::print("{:<18} {:>16.3f} {:>12} of {:<4} {:>14.1f} {:>+14.2f}\n", kNames[n], 100 * t.worst_error[n],
                 t.within_3_sigma[n], t.trials, 100.0 * t.covered[n] / t.trials, t.mean_z[n]);
  }
  if (json) fmt::print("{}\n", rows.dump(2));
  return 0;
}

}  // namespace firn::bench::estimator_coverage
