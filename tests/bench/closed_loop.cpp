// Measures the final RMS error of closed-loop prints: error of the true surface about the target, over seeds
// that nothing was tuned on. The whole lab runs in simulated time. The part is a disc of 38 on 40 x 40 cells,
// 0.4 mm high.
//   closed_loop [--plant lu2015|droplets] [--seeds N] [--first SEED] [--scheme WORDS (beside greedy)] [--set
//   KEY=VALUE]... [--json]
//               [--alone (greedy not)] [--sensor UM (noise per cell, this one only)] [--each (each print, and
//               its error by place)] [-o FOLDER and a study's options]
// lu2015: the paper's own model, variation 20 and 40 %, without sensor noise and with 1 um per cell. It is
// the model that MPC plans with, so it flatters. droplets: Firn's independent plant, as it is by default.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
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
#include "tests/bench/case_bench.h"

namespace firn::bench::closed_loop {

namespace {

using namespace firn;
using Json = nlohmann::ordered_json;

struct Row {
  const char* name;
  std::vector<std::string> set;
};

constexpr const char* kGreedy = "greedy N=1";

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
  return {{kGreedy, {"control.mpc.method=greedy"}},
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

// A scheme in one lab.
struct Kind {
  std::string scheme;
  double variation, sensor_um;
  Experiment experiment;
};

struct Asked {
  int seeds = 20, first = 1001;
  bool json = false, each = false, alone = false;
  std::string plant = "lu2015", only;
  std::vector<std::string> more;
  double just_um = -1.0;

  bool own() const { return plant == "droplets"; }
  std::vector<std::string> words() const;
};

std::vector<std::string> Asked::words() const {
  std::vector<std::string> words = {
      "--seeds", std::to_string(seeds), "--first", std::to_string(first), "--plant", plant};
  if (!only.empty()) words.insert(words.end(), {"--scheme", only});
  for (const std::string& one : more) words.insert(words.end(), {"--set", one});
  if (just_um >= 0.0) words.insert(words.end(), {"--sensor", fmt::format("{}", just_um)});
  if (alone) words.push_back("--alone");
  return words;
}

Experiment experiment_of(const Asked& asked, const Row& row, double variation, double sensor_um) {
  Experiment e = lu_lab("cylinder", 38.0, 0.4);
  e.plant.model = asked.plant;
  e.plant.dropout_fraction = asked.own() ? Experiment{}.plant.dropout_fraction : 0.0;
  e.plant.variation = variation;
  e.plant.sensor_noise_mm = 1e-3 * sensor_um * kPointNoiseOfCell;
  std::vector<std::string> overrides = row.set;
  overrides.insert(overrides.end(), asked.more.begin(), asked.more.end());
  return parse_experiment({{"closed_loop", dump(e)}}, overrides);
}

std::vector<Kind> kinds(const Asked& asked) {
  const std::vector<double> variations =
                                asked.own() ? std::vector<double>{0.0} : std::vector<double>{0.2, 0.4},
                            sensors_um = asked.own() ? std::vector<double>{1.0 / kPointNoiseOfCell, 1.0}
                                                     : std::vector<double>{0.0, 1.0};
  std::vector<Kind> kinds;
  for (const Row& row : rows()) {
    if (!asked.only.empty() && asked.only != row.name && (asked.alone || std::string(kGreedy) != row.name))
      continue;
    for (const double variation : variations)
      for (const double sensor_um : sensors_um)
        if (asked.just_um < 0.0 || std::abs(sensor_um - asked.just_um) <= 0.01)
          kinds.push_back({row.name, variation, sensor_um, experiment_of(asked, row, variation, sensor_um)});
  }
  return kinds;
}

// Mean, standard deviation and share of the mean square of the error [um] by place; empty places are left
// out.
Json by_place(const MemoryPrintReport& r, const Blobs& inputs, const Experiment& e) {
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  const Grid<droplet::Place> places = droplet::places_of(mask);
  constexpr const char* kNames[3] = {"inside", "rim", "between"};
  Json of = Json::object();
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
      of[kNames[place]] = {sum / n, std::sqrt(std::max(0.0, square / n - sum / n * sum / n)), square / all};
  }
  return of;
}

std::string print(const Kind& kind, std::uint64_t seed) {
  Experiment e = kind.experiment;
  const Blobs inputs = make_inputs(full_product(), e, ".");
  e.plant.seed = seed;
  const MemoryPrintReport r = print_in_memory(full_product(), e, inputs, {.surface = true});
  return Json{{"reason", r.result.status == 0 ? "" : r.result.reason},
              {"rms_um", 1e3 * r.error.rms_mm},
              {"mean_um", 1e3 * r.error.mean_mm},
              {"max_um", 1e3 * r.error.max_mm},
              {"min_um", 1e3 * r.error.min_mm},
              {"layers", r.result.layers},
              {"decide_cpu_s", r.decide_cpu_s},
              {"places", by_place(r, inputs, e)}}
      .dump();
}

void tell_each(std::uint64_t seed, const Json& r) {
  fmt::print("  seed {} rms {:.3f} mean {:+.3f} max {:+.2f} min {:+.2f} layers {}", seed,
             r["rms_um"].get<double>(), r["mean_um"].get<double>(), r["max_um"].get<double>(),
             r["min_um"].get<double>(), r["layers"].get<int>());
  for (const auto& [name, of] : r["places"].items())
    fmt::print("  {} {:+.3f} sd {:.3f} part of square {:.3f}", name, of[0].get<double>(), of[1].get<double>(),
               of[2].get<double>());
  fmt::print("\n");
}

/// Sums of one scheme in one lab over the seeds.
struct Total {
  std::vector<double> rms_um;  ///< NaN of a print that failed
  double worst_mean_um = 0.0, worst_um = 0.0, layers = 0.0, decide_cpu_s = 0.0, cpu_s = 0.0;
};

Total total_of(const Kind& kind, const std::vector<std::uint64_t>& seeds, const CaseBench::Result* results,
               bool each) {
  Total t;
  for (std::size_t n = 0; n < seeds.size(); ++n) {
    const CaseBench::Result& result = results[n];
    const Json r = result.made ? Json::parse(result.text) : Json{{"reason", result.reason}};
    if (const std::string reason = r["reason"]; !reason.empty())
      fmt::print(stderr, "{} seed {}: {}\n", kind.scheme, seeds[n], reason);
    if (!result.made) {
      t.rms_um.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    if (each) tell_each(seeds[n], r);
    t.rms_um.push_back(r["rms_um"]);
    t.worst_mean_um = std::max(t.worst_mean_um, std::abs(r["mean_um"].get<double>()));
    t.worst_um = std::max({t.worst_um, r["max_um"].get<double>(), -r["min_um"].get<double>()});
    t.layers += r["layers"].get<double>() / double(seeds.size());
    t.decide_cpu_s += r["decide_cpu_s"].get<double>() / double(seeds.size());
    t.cpu_s += result.cpu_s / double(seeds.size());
  }
  return t;
}

Json json_of(const Asked& asked, const Kind& k, const Total& t) {
  const auto i = statistics::bootstrap_interval(t.rms_um);
  return {{"scheme", k.scheme},
          {"plant", asked.plant},
          {"variation", k.variation},
          {"sensor_um_per_cell", k.sensor_um},
          {"rms_um", statistics::mean(t.rms_um)},
          {"rms_low_um", i.low},
          {"rms_high_um", i.high},
          {"worst_mean_um", t.worst_mean_um},
          {"worst_um", t.worst_um},
          {"layers", t.layers},
          {"cpu_s", t.cpu_s},
          {"decide_cpu_s", t.decide_cpu_s}};
}

void tell(const Kind& k, const Total& t, const std::vector<double>& ratio) {
  const auto i = statistics::bootstrap_interval(t.rms_um);
  fmt::print("{:<24} {:>8.0f}% {:>7.2f} {:>22} {:>8.3f} {:>8.2f} {:>7.1f} {:>7.2f} {:>7.2f}", k.scheme,
             100 * k.variation, k.sensor_um,
             fmt::format("{:.3f} [{:.3f}, {:.3f}]", statistics::mean(t.rms_um), i.low, i.high),
             t.worst_mean_um, t.worst_um, t.layers, t.cpu_s, t.decide_cpu_s);
  if (!ratio.empty()) {
    const auto q = statistics::bootstrap_interval(ratio);
    fmt::print("   {:.3f} [{:.3f}, {:.3f}] of greedy", statistics::mean(ratio), q.low, q.high);
  }
  fmt::print("\n");
}

void tell_all(const Asked& asked, const std::vector<Kind>& kinds, const std::vector<std::uint64_t>& seeds,
              const std::vector<CaseBench::Result>& results) {
  if (!asked.json)
    fmt::print("{} seeds from {}, plant {}\n{:<24} {:>9} {:>7} {:>22} {:>8} {:>8} {:>7} {:>7} {:>7}\n",
               asked.seeds, asked.first, asked.plant, "scheme", "variation", "sensor", "RMS [um]", "|mean|",
               "max", "layers", "CPU s", "decide");
  Json table = Json::array();
  std::vector<std::vector<double>> of_greedy;  // by lab: the labs of each scheme come in one order
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const Kind& kind = kinds[k];
    const Total t = total_of(kind, seeds, &results[k * seeds.size()], asked.each && !asked.json);
    if (kind.scheme == kGreedy) of_greedy.push_back(t.rms_um);
    std::vector<double> ratio;
    if (!of_greedy.empty())
      for (std::size_t n = 0; n < seeds.size(); ++n)
        ratio.push_back(t.rms_um[n] /
                        of_greedy[kind.scheme == kGreedy ? of_greedy.size() - 1 : k % of_greedy.size()][n]);
    if (!asked.json) {
      tell(kind, t, ratio);
      continue;
    }
    table.push_back(json_of(asked, kind, t));
    if (ratio.empty()) continue;
    const auto q = statistics::bootstrap_interval(ratio);
    table.back()["ratio_to_greedy"] = {statistics::mean(ratio), q.low, q.high};
  }
  if (asked.json) fmt::print("{}\n", table.dump(2));
}

}  // namespace

FIRN_BENCH(closed_loop) try {
  Asked asked;
  std::vector<std::string> names;
  for (const Row& row : rows()) names.push_back(row.name);
  CaseBench bench("closed_loop", "closed loops of schemes on held-out seeds");
  bench.options().option("--seeds", asked.seeds, "how many").show_default().within(1, 1000000);
  bench.options().option("--first", asked.first, "seed").show_default().within(0, 1000000000);
  bench.options().option("--plant", asked.plant, "").show_default().one_of({"lu2015", "droplets"});
  bench.options().option("--scheme", asked.only, "beside greedy").one_of(names);
  bench.options().option("--sensor", asked.just_um, "UM: noise per cell, this one only").within(0.0, 1000.0);
  bench.options().override_option(asked.more);
  bench.options().flag("--alone", asked.alone, "greedy not");
  bench.options().flag("--each", asked.each, "each print, and its error by place");
  bench.options().json_flag(bench.study.json);
  if (const auto code = bench.parse(argc, argv)) return *code;
  asked.json = bench.study.json;
  const std::vector<Kind> all = kinds(asked);
  Cases cases{"closed_loop", "", {}, {}, {}};
  for (const Kind& k : all) {
    cases.kinds.push_back(fmt::format("{}, {:.0f} %, {:.2f} um", k.scheme, 100 * k.variation, k.sensor_um));
    cases.settings += dump(k.experiment);
  }
  for (int n = 0; n < asked.seeds; ++n) cases.seeds.push_back(std::uint64_t(asked.first + n));
  cases.make = [&](std::size_t kind, std::uint64_t seed, int) { return print(all[kind], seed); };
  int code = 0;
  const auto results = bench.results(cases, asked.words(), code);
  if (results) tell_all(asked, all, cases.seeds, *results);
  return code;
} catch (const std::exception& e) {
  fmt::print(stderr, "closed_loop: {}\n", e.what());
  return 2;
}

}  // namespace firn::bench::closed_loop
