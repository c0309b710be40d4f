// Measures the final RMS error of closed-loop prints: error of the true surface about the target, over seeds
// that nothing was tuned on. The whole lab runs in simulated time. The part is a disc of 38 on 40 x 40 cells,
// 0.4 mm high.
//   closed_loop [--plant lu2015|droplets] [--seeds N] [--first SEED] [--scheme WORDS (beside greedy)] [--set
//   KEY=VALUE]... [--json]
//               [--alone (greedy not)] [--sensor UM (noise per cell, this one only)] [--each (each print, and
//               its error by place)]
// lu2015: the paper's own model, variation 20 and 40 %, without sensor noise and with 1 um per cell. It is
// the model that MPC plans with, so it flatters. droplets: Firn's independent plant, as it is by default.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include "config/include.h"
#include "core/grid/npy.h"
#include "core/statistics/bootstrap.h"
#include "estimators/droplet/droplet_factors.h"
#include "files/json.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "studies/reproduce/lu/lu_prints.h"
#include "tests/bench/bench.h"

namespace firn::bench::closed_loop {

namespace {

using namespace firn;

struct Row {
  const char* name;
  std::vector<std::string> set;
};

// Averaging over a cell leaves 0.283 of the noise of one profile point.
constexpr double kPointNoiseOfCell = 1.0 / 0.283;

std::vector<Row> rows() {
  const auto and_ = [](std::vector<std::string> set, const std::vector<std::string>& more) {
    set.insert(set.end(), more.begin(), more.end());
    return set;
  };
  const std::vector<std::string> strips = {"control.mpc.method=strip_dp"};
  const std::vector<std::string> three =
      and_(strips, {"control.mpc.horizon=3", "control.mpc.anneal_sweeps=50"});
  // The surface filtered, the model as configured: this scheme holds where the model is only roughly
  // nature's.
  const std::vector<std::string> filter = {"control.height_estimate=kalman", "control.droplet_scatter=0.1"};
  // The model learned as well: about 10 ms a layer.
  const std::vector<std::string> learned = {"control.height_estimate=kalman", "control.adapt_model=on",
                                            "estimator.droplets=on",          "estimator.memory_layers=20",
                                            "estimator.window_layers=2",      "estimator.max_evaluations=12"};
  // The height that droplets add is learned inside the part and on its rim. The model's errors count as
  // scatter, so that droplets that hardly pay are not fired. The last two layers wait for the rim.
  const std::vector<std::string> factors = {"control.height_estimate=kalman", "control.droplet_factors=on",
                                            "control.droplet_scatter=0.3", "control.mpc.error=square",
                                            "control.mpc.finish_layers=2"};
  // The same, the inside waiting for the rim all the way up, and the last layers planned from full ones.
  const std::vector<std::string> together =
      and_(factors, {"control.droplet_factors=together", "control.mpc.finish_layers=3"});
  return {{"greedy N=1", {"control.mpc.method=greedy"}},
          {"strips N=1", strips},
          {"strips N=1, learned", and_(strips, learned)},
          {"strips N=3", three},
          {"strips N=3, filter", and_(three, filter)},
          {"strips N=3, factors", and_(three, factors)},
          {"strips N=3, together", and_(three, together)},
          {"strips N=3, learned", and_(three, learned)},
          {"the same, squares", and_(and_(three, learned), {"control.mpc.error=square"})},
          {"the same, squares and mean", and_(and_(three, learned), {"control.mpc.error=square_mean"})}};
}

// One print: its error, and mean and mean square of it by place.
void tell_each(int seed, const MemoryPrintReport& r, const Blobs& inputs, const Experiment& e) {
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  const Grid<droplet::Place> places = droplet::places_of(mask);
  fmt::print("  seed {} rms {:.3f} mean {:+.3f} max {:+.2f} min {:+.2f} layers {}", seed,
             1e3 * r.error.rms_mm, 1e3 * r.error.mean_mm, 1e3 * r.error.max_mm, 1e3 * r.error.min_mm,
             r.result.layers);
  constexpr const char* kNames[3] = {"inside", "rim", "between"};
  for (const int place : {1, 2, 0}) {
    double n = 0.0, sum = 0.0, square = 0.0, all = 0.0;
    for (std::size_t c = 0; c < mask.size(); ++c) {
      if (!mask.cells[c]) continue;
      all += 1.0;
      if (int(places.cells[c]) != place) continue;
      const double error = 1e3 * (r.surface.cells[c] - target.cells[c]);
      n += 1.0;
      sum += error;
      square += error * error;
    }
    if (n > 0.0)
      fmt::print("  {} {:+.3f} sd {:.3f} part of square {:.3f}", kNames[place], sum / n,
                 std::sqrt(std::max(0.0, square / n - sum / n * sum / n)), square / all);
  }
  fmt::print("\n");
}

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace

FIRN_BENCH(closed_loop) try {
  int seeds = 20, first = 1001;
  bool json = false, each = false, alone = false;
  std::string plant = "lu2015", only;
  std::vector<std::string> more, names;
  for (const Row& row : rows()) names.push_back(row.name);
  double just_um = -1.0;
  CLI::App app("closed loops of schemes on held-out seeds");
  app.add_option("--seeds", seeds, "how many")->check(CLI::Range(1, 1000000));
  app.add_option("--first", first, "seed")->check(CLI::Range(0, 1000000000));
  app.add_option("--plant", plant)->check(CLI::IsMember({"lu2015", "droplets"}));
  app.add_option("--scheme", only, "beside greedy")->check(CLI::IsMember(names));
  app.add_option("--sensor", just_um, "UM: noise per cell, this one only")->check(CLI::Range(0.0, 1000.0));
  app.add_option("--set", more, "KEY=VALUE")->allow_extra_args(false);
  app.add_flag("--alone", alone, "greedy not");
  app.add_flag("--each", each, "each print, and its error by place");
  app.add_flag("--json", json);
  CLI11_PARSE(app, argc, argv);
  nlohmann::ordered_json table = nlohmann::json::array();
  if (!json)
    fmt::print("{} seeds from {}, plant {}\n{:<24} {:>9} {:>7} {:>22} {:>8} {:>8} {:>7} {:>7} {:>7}\n", seeds,
               first, plant, "scheme", "variation", "sensor", "RMS [um]", "|mean|", "max", "layers", "CPU s",
               "decide");
  const bool own = plant == "droplets";
  std::vector<std::vector<double>> of_greedy;
  for (const Row& row : rows()) {
    if (!only.empty() && only != row.name && (alone || std::string("greedy N=1") != row.name)) continue;
    std::size_t set_up = 0;
    for (const double variation : own ? std::vector<double>{0.0} : std::vector<double>{0.2, 0.4})
      for (const double sensor_um :
           own ? std::vector<double>{1.0 / kPointNoiseOfCell, 1.0} : std::vector<double>{0.0, 1.0}) {
        if (just_um >= 0.0 && std::abs(sensor_um - just_um) > 0.01) continue;
        Experiment e = lu_lab("cylinder", 38.0, 0.4);
        e.plant.model = plant;
        e.plant.dropout_fraction = own ? Experiment{}.plant.dropout_fraction : 0.0;
        e.plant.variation = variation;
        e.plant.sensor_noise_mm = 1e-3 * sensor_um * kPointNoiseOfCell;
        std::vector<std::string> overrides = row.set;
        overrides.insert(overrides.end(), more.begin(), more.end());
        e = parse_experiment({{"closed_loop", dump(e)}}, overrides);
        const Blobs inputs = make_inputs(full_product(), e, ".");
        std::vector<double> rms, ratio;
        double mean_mm = 0.0, max_mm = 0.0, layers = 0.0, decide = 0.0;
        const double before = cpu_s();
        for (int n = 0; n < seeds; ++n) {
          e.plant.seed = std::uint64_t(first + n);
          const MemoryPrintReport r = print_in_memory(full_product(), e, inputs, {.surface = each});
          if (r.result.status != 0)
            fmt::print(stderr, "{} seed {}: {}\n", row.name, first + n, r.result.reason);
          if (each) tell_each(first + n, r, inputs, e);
          rms.push_back(1e3 * r.error.rms_mm);
          mean_mm = std::max(mean_mm, std::abs(r.error.mean_mm));
          max_mm = std::max({max_mm, r.error.max_mm, -r.error.min_mm});
          layers += double(r.result.layers) / seeds;
          decide += r.decide_cpu_s / seeds;
        }
        const double cpu = (cpu_s() - before) / seeds;
        if (row.name == std::string("greedy N=1")) of_greedy.push_back(rms);
        if (set_up < of_greedy.size())
          for (std::size_t n = 0; n < rms.size(); ++n) ratio.push_back(rms[n] / of_greedy[set_up][n]);
        ++set_up;
        const auto i = statistics::bootstrap_interval(rms);
        std::string told = fmt::format("{:.3f} [{:.3f}, {:.3f}]", statistics::mean(rms), i.low, i.high);
        if (json) {
          table.push_back({{"scheme", row.name},
                           {"plant", plant},
                           {"variation", variation},
                           {"sensor_um_per_cell", sensor_um},
                           {"rms_um", statistics::mean(rms)},
                           {"rms_low_um", i.low},
                           {"rms_high_um", i.high},
                           {"worst_mean_um", 1e3 * mean_mm},
                           {"worst_um", 1e3 * max_mm},
                           {"layers", layers},
                           {"cpu_s", cpu},
                           {"decide_cpu_s", decide}});
          if (!ratio.empty()) {
            const auto q = statistics::bootstrap_interval(ratio);
            table.back()["ratio_to_greedy"] = {statistics::mean(ratio), q.low, q.high};
          }
          continue;
        }
        fmt::print("{:<24} {:>8.0f}% {:>7.2f} {:>22} {:>8.3f} {:>8.2f} {:>7.1f} {:>7.2f} {:>7.2f}", row.name,
                   100 * variation, sensor_um, told, 1e3 * mean_mm, 1e3 * max_mm, layers, cpu, decide);
        if (!ratio.empty()) {
          const auto q = statistics::bootstrap_interval(ratio);
          fmt::print("   {:.3f} [{:.3f}, {:.3f}] of greedy", statistics::mean(ratio), q.low, q.high);
        }
        fmt::print("\n");
        std::fflush(stdout);
      }
  }
  if (json) fmt::print("{}\n", table.dump(2));
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "closed_loop: {}\n", e.what());
  return 2;
}

}  // namespace firn::bench::closed_loop
