// Measures the errors of h1, h2, h3 and of their intervals after ten random half-filled layers on the plant
// "lu2015", whose values are known: maximum error, errors within 3 sigma, share of seeds that the 95 %
// intervals cover.
//   estimator_coverage [--seeds N] [--variation V] [--experiment FILE] [--json] [-o FOLDER and a study's
//   options]
#include <fmt/core.h>

#include <filesystem>
#include <string>
#include <vector>

#include "config/fields.h"
#include "config/include.h"
#include "files/json.h"
#include "tests/bench/bench.h"
#include "tests/bench/case_bench.h"
#include "tests/support/planted_trial.h"

namespace firn::bench::estimator_coverage {

FIRN_BENCH(estimator_coverage) {
  using namespace firn;
  int seeds = 200;
  double variation = 0.2;
  bool json = false;
  std::string experiment = FIRN_SOURCE_DIR "/experiments/excitation.toml";
  CaseBench bench("estimator_coverage", "errors of h1, h2, h3 and of their intervals on planted values");
  bench.options().option("--seeds", seeds, "").show_default().within(1, 1000000);
  bench.options().option("--variation", variation, "of the droplets").show_default().within(0.0, 1.0);
  bench.options().option("--experiment", experiment, "file").show_default();
  bench.options().json_flag(json);
  if (const auto code = bench.parse(argc, argv)) return *code;
  experiment = std::filesystem::absolute(experiment).string();
  Cases cases{"estimator_coverage",
              dump(load_experiment(experiment)),
              {fmt::format("variation {}", variation)},
              {},
              {}};
  for (int n = 1; n <= seeds; ++n) cases.seeds.push_back(std::uint64_t(n));
  cases.make = [&](std::size_t, std::uint64_t seed, int) {
    const PlantedTrial trial = planted_trial(experiment, seed, variation);
    std::vector<double> numbers;
    for (const double* of : {trial.truth_mm, trial.ours_mm, trial.sigma_mm})
      numbers.insert(numbers.end(), of, of + 4);
    return text_of(numbers);
  };
  int code = 0;
  const auto results = bench.results(cases,
                                     {"--seeds", std::to_string(seeds), "--variation",
                                      fmt::format("{}", variation), "--experiment", experiment},
                                     code);
  if (!results) return code;
  std::vector<PlantedTrial> trials;
  for (std::size_t n = 0; n < results->size(); ++n) {
    const CaseBench::Result& r = (*results)[n];
    if (!r.made) {
      fmt::print("seed {}: {}\n", cases.seeds[n], r.reason);
      continue;
    }
    const std::vector<double> numbers = numbers_of(r.text);
    PlantedTrial& trial = trials.emplace_back();
    for (std::size_t h = 0; h < 4; ++h) {
      trial.truth_mm[h] = numbers[h];
      trial.ours_mm[h] = numbers[4 + h];
      trial.sigma_mm[h] = numbers[8 + h];
    }
  }
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
