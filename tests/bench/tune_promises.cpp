// Promises of firn tune held against prints, over laboratories that are drawn at random. Parameters are drawn
// from the classes' own distributions; part, keys, recorded setting and disturbances are drawn too.
//   tune_promises [LABS] [--seed S] [--first N] [--kind KIND]... [--part EXPERIMENT] [--pairs N] [--budget N]
//                 [-o FOLDER and a study's options]
// KIND: droplets, height-change; optimal: droplets whose recorded setting is the oracle's, so that nothing
// can be gained; mpc, estimator, spacing: droplets with other keys; ice, ice-foresee: the ice printer under
// smf and smf_foresee; pressure, flight: droplets at the far end of what the tuner takes for possible;
// thin-film, dead-row, tilted: laboratories of no class that it knows. Without --part a cylinder or a block
// within 16 x 16 cells is printed, of eight to twelve layers, with 64 points a profile. Laboratory n of a
// seed is the same whatever was run before it (--first); those on record in FOLDER are not run again.
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/fields.h"
#include "config/include.h"
#include "core/grid/random.h"
#include "estimators/lab/box_search.h"
#include "print/labs/full_product.h"
#include "studies/identify/identification_study.h"
#include "studies/tune/advice.h"
#include "studies/tune/tune_answer.h"
#include "tests/bench/bench.h"
#include "tests/bench/case_bench.h"
#include "tests/bench/promise_rows.h"
#include "tests/support/ice_print.h"

namespace firn::bench::tune_promises {

using namespace firn;
using namespace firn::tune;

namespace {

constexpr int kOracleEvaluations = 18, kOraclePrints = 5;

double cpu_s() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return double(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * double(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

// A film that levels far more than a droplet does.
void thin_film(plant::WorldConfig& w) {
  w.droplet.levelling_steps = 12;
  w.droplet.levelling = 0.25;
  w.droplet.run_share = 0.25;
}
// A line whose pressure falls by a third within a layer.
void weak_pressure(plant::WorldConfig& w) {
  w.nozzle.drift = true;
  w.nozzle.pressure_per_drop = 3e-4;
}
// Droplets that land a third of a cell ahead, the other way in every other row.
void late_flight(plant::WorldConfig& w) { w.droplet.flight_time_s = 6e-4; }
// A row in the middle of the part that gets no droplet.
void dead_row(plant::WorldConfig& w) { w.droplet.dead_row = w.grid.ny / 2; }
// A sensor that hangs askew by an eighth of a degree.
void tilted_sensor(plant::WorldConfig& w) { w.sensor.tilt = 0.0022; }

struct Nature {
  const char* kind;
  void (*set)(plant::WorldConfig&);
};
constexpr Nature kStrange[] = {
    {"thin-film", &thin_film}, {"pressure", &weak_pressure}, {"flight", &late_flight},
    {"dead-row", &dead_row},   {"tilted", &tilted_sensor},
};
// Droplets in a laboratory of a kind, with the parameters drawn for the others.
template <std::size_t kKind>
void strange_droplets(std::span<const double> values, plant::WorldConfig& w) {
  lab_classes()[0].nature(values, w);
  kStrange[kKind].set(w);
}
template <std::size_t... kKinds>
constexpr auto strange_natures(std::index_sequence<kKinds...>) {
  return std::array{&strange_droplets<kKinds>...};
}
constexpr auto kStrangeNatures = strange_natures(std::make_index_sequence<std::size(kStrange)>());

constexpr int kIceIntervals = 6;

bool of_ice(const std::string& kind) { return kind.starts_with("ice"); }

std::vector<std::string> settings_of(const std::string& kind, bool small) {
  if (of_ice(kind))
    return {"ice.paths=\"-\"", "ice.interval_layers=1",
            kind == "ice" ? "control.scheme=smf" : "control.scheme=smf_foresee"};
  std::vector<std::string> s{kind == "mpc" || kind == "estimator" ? "control.scheme=mpc"
                                                                  : "control.scheme=smf"};
  if (kind == "estimator") s.insert(s.end(), {"estimator.droplets=on", "control.adapt_model=on"});
  if (small)
    for (const char* set : {"grid.nx=16", "grid.ny=16", "part.diameter_mm=3.7", "part.height_mm=0.07",
                            "laser_profiler.points=64", "process.scan_speed_mm_s=15.0"})
      s.emplace_back(set);
  return s;
}

struct Case {
  LabDraw lab;
  Experiment experiment;
  Blobs inputs;
  std::vector<TuneKey> keys;
  std::vector<std::string> key_texts = {};  ///< with ranges
};

struct Options {
  std::string file, kind;
  std::uint64_t seed = 1;
  int labs = 10, first = 0, threads = 2, pairs = 10, budget = 420;
};

class Bench {
 public:
  explicit Bench(const Options& o)
      : o_(o),
        file_(!o.file.empty()  ? o.file
              : of_ice(o.kind) ? FIRN_SOURCE_DIR "/labs/ice-cobra600.toml"
                               : FIRN_SOURCE_DIR "/experiments/demo.toml"),
        base_(load_experiment(file_, settings_of(o.kind, o.file.empty()))),
        goal_(goal_index(base_, "rms")),
        lab_(lab_classes(lab_of(base_).deposition)[o.kind == "height-change" ? 1 : 0]) {
    for (std::size_t n = 0; n < std::size(kStrange); ++n)
      if (o.kind == kStrange[n].kind) lab_.nature = kStrangeNatures[n];
  }

  /// The answer in laboratory n, and how it fared.
  PromiseRow row(int n) const { return one(n); }

 private:
  std::vector<LabPrint> prints_of(const Case& c, const Experiment& e, std::uint32_t stream,
                                  int prints) const {
    std::vector<LabPrint> made(std::size_t(prints), LabPrint{});
    const Blobs own = e.grid == c.experiment.grid ? Blobs() : make_inputs(full_product(), e, ".");
    const Blobs& inputs = own.empty() ? c.inputs : own;
    run_jobs(prints, o_.threads, [&](int n) {
      LabDraw draw = c.lab;
      draw.seed = print_seed({c.lab.seed, Purpose::kTest, stream, 0, std::uint32_t(n)});
      made[std::size_t(n)] = print_in_lab(e, inputs, draw, {});
    });
    return made;
  }
  /// NaN for a print that does not finish.
  std::vector<double> goals(const Case& c, const Experiment& e, std::uint32_t stream, int prints) const {
    std::vector<double> goal;
    for (const LabPrint& p : prints_of(c, e, stream, prints))
      goal.push_back(p.finished ? p.metrics[goal_] : NAN);
    return goal;
  }

  /// Means over the oracle's prints that finish.
  struct OraclePrints {
    double goal = 0.0;
    int finished = 0;
    PrintTraits traits;
  };
  OraclePrints oracle_prints(const Case& c, const Experiment& e) const {
    OraclePrints mean;
    for (const LabPrint& p : prints_of(c, e, 1, kOraclePrints)) {
      if (!p.finished || p.metrics.empty()) continue;
      ++mean.finished;
      mean.goal += p.metrics[goal_];
      mean.traits.saturated += p.traits.saturated;
      mean.traits.alternation += p.traits.alternation;
      mean.traits.swing += p.traits.swing;
      mean.traits.overspill += p.traits.overspill;
    }
    for (double* m : {&mean.goal, &mean.traits.saturated, &mean.traits.alternation, &mean.traits.swing,
                      &mean.traits.overspill})
      *m /= std::max(1, mean.finished);
    return mean;
  }

  /// A setting with which prints stop, or that the tuner leaves out as unsafe, is no candidate of the oracle.
  double oracle_goal(const Case& c, const Experiment& e, const PrintTraits& recorded) const {
    const OraclePrints o = oracle_prints(c, e);
    return 2 * o.finished > kOraclePrints && unsafe_trait(o.traits, recorded).empty() ? o.goal : 1e3;
  }

  /// Goals over the pairs of which all finish.
  void print_pairs(const Case& c, const Setting& advice, const Setting& best, PromiseRow& row) const {
    const Experiment plain = without_plant(c.experiment);
    const auto a = goals(c, plain, 2, o_.pairs),
               b = goals(c, with_setting(c.keys, advice, plain), 2, o_.pairs),
               o = goals(c, with_setting(c.keys, best, plain), 2, o_.pairs);
    double whole = 0.0, before = 0.0, gain = 0.0, oracle = 0.0;
    for (std::size_t n = 0; n < a.size(); ++n) {
      row.stopped_more += int(std::isnan(b[n])) - int(std::isnan(a[n]));
      if (std::isnan(a[n] + b[n] + o[n])) continue;
      whole += 1.0;
      before += a[n];
      gain += a[n] - b[n];
      oracle += a[n] - o[n];
    }
    row.before = before / whole;
    row.printed = gain / whole;
    row.oracle = oracle / whole;
  }

  /// The best setting that a search in the laboratory itself finds.
  Setting oracle(const Case& c) const {
    const Experiment plain = without_plant(c.experiment);
    const auto setting_at = [&](std::span<const double> u) {
      Setting s;
      for (std::size_t k = 0; k < c.keys.size(); ++k) s.push_back(c.keys[k].at(u[k]));
      return s;
    };
    const PrintTraits recorded = oracle_prints(c, plain).traits;
    std::vector<double> start;
    for (const TuneKey& k : c.keys) start.push_back(k.place(k.recorded()));
    const auto points = lab::minimise_in_box(
        [&](std::span<const double> u) {
          return oracle_goal(c, with_setting(c.keys, setting_at(u), plain), recorded);
        },
        start, kOracleEvaluations);
    return setting_at(std::ranges::min_element(points, {}, &lab::BoxPoint::value)->u);
  }

  void draw_part(RandomStream& random, ShapeSpec& shape) const {
    const bool round = random.uniform() < 0.5;
    shape.kind = round ? "cylinder" : "cuboid";
    shape.diameter_mm = round ? random.uniform(3.0, 3.9) : 0.0;
    shape.width_mm = round ? 0.0 : random.uniform(2.5, 3.7);
    shape.depth_mm = round ? 0.0 : random.uniform(2.5, 3.7);
    shape.height_mm = random.uniform(0.06, 0.09);
  }

  static void set_recorded(Case& c, const Setting& setting) {
    c.experiment = with_setting(c.keys, setting, c.experiment);
    c.keys.clear();
    for (const std::string& text : c.key_texts) c.keys.emplace_back(text, c.experiment);
  }

  /// Keys with the values that are recorded.
  void draw_keys(RandomStream& random, Case& c) const {
    auto& smf = c.experiment.control.smf;
    smf.kp = random.uniform(0.3, 1.4);
    smf.ki_star = random.uniform(0.0, 0.6);
    smf.kd_star = 0.0;
    static const std::vector<std::vector<std::string>> kKeys = {
        {"control.smf.kp", "control.smf.ki_star"},
        {"control.smf.kp", "control.smf.ki_star"},
        {"control.smf.ki_star"},
        {"control.smf.kp", "control.noise_gate=0.2:20"}};
    static const std::vector<std::vector<std::string>> kMpcKeys = {
        {"control.mpc.alpha=0.05:1"}, {"control.noise_gate=0.2:20"}, {"control.mpc.horizon=1:2"}};
    static const std::vector<std::vector<std::string>> kEstimator = {{"estimator.memory_layers=3:30"}},
                                                       kSpacingKey = {{std::string(kSpacing)}},
                                                       kIce = {{"control.smf.kp=0.05:1.4"}},
                                                       kForesee = {{"control.foresee.flow_gain"}};
    const auto& groups = o_.kind == "mpc"           ? kMpcKeys
                         : o_.kind == "estimator"   ? kEstimator
                         : o_.kind == "spacing"     ? kSpacingKey
                         : o_.kind == "ice"         ? kIce
                         : o_.kind == "ice-foresee" ? kForesee
                                                    : kKeys;
    c.key_texts = groups[std::size_t(random.uniform() * double(groups.size()))];
    for (const std::string& text : c.key_texts) c.keys.emplace_back(text, c.experiment);
    if (&groups == &kKeys) return;
    Setting recorded;
    for (const TuneKey& k : c.keys) {
      const double u = random.uniform();
      recorded.push_back(k.enumerated() ? k.values()[std::size_t(u * double(k.values().size()))]
                                        : k.at(0.1 + 0.8 * u));
    }
    set_recorded(c, recorded);
  }

  Case draw(int n) const {
    RandomStream random(o_.seed, Purpose::kTest, std::uint32_t(n), 77);
    Case c{{&lab_, {}, random.bits() >> 2}, base_, {}, {}};
    for (std::size_t p = 0; p < lab_.parameters.size(); ++p) c.lab.z.push_back(random.normal());
    if (o_.file.empty() && !of_ice(o_.kind)) draw_part(random, c.experiment.part.shape);
    draw_keys(random, c);
    if (of_ice(o_.kind))
      c.inputs = {{"paths", "", slice::encode(test::ice_block(kIceIntervals))}, {"machine", "", {}}};
    else
      c.inputs = make_inputs(full_product(), c.experiment, std::filesystem::path(file_).parent_path());
    return c;
  }

  PromiseRow one(int n) const {
    Case c = draw(n);
    PromiseRow row;
    row.kind = o_.kind;
    row.lab = n;
    if (o_.kind == "optimal") set_recorded(c, oracle(c));
    row.keys = text_of(c.keys, recorded_setting(c.keys));
    const LabPrint log = print_in_lab(without_plant(c.experiment), c.inputs, c.lab, {.features = true});
    if (log.features.empty()) {
      row.answer = "unfinished";
      row.feature = log.reason;
      return row;
    }
    const double began = cpu_s();
    const std::vector<RecordedRun> runs{{"lab", c.experiment, c.inputs, log.features, 0}};
    const int fit_prints = int(0.41 * o_.budget);
    const std::uint64_t seed = o_.seed + std::uint64_t(n);
    const FittedLab fit = fit_lab(runs, {.seed = seed, .threads = o_.threads, .prints = fit_prints});
    if (!fit.check.passed()) {
      row.cpu_s = cpu_s() - began;
      row.answer = "refused";
      row.feature =
          fmt::format("{} ({:+.1f})", fit.check.missed.front().feature, fit.check.missed.front().deviation);
      return row;
    }
    const Advice advice = advise(fit, runs[0], c.keys,
                                 {.goal = goal_,
                                  .seed = seed,
                                  .threads = o_.threads,
                                  .prints = o_.budget - fit_prints,
                                  .promised_prints = o_.pairs});
    row.cpu_s = cpu_s() - began;
    row.answer = advice.gain_shown ? "advised" : "kept";
    row.feature = fmt::format("{:.1f} of {:.1f}; {:.1f} of {:.1f}; {}; {:.2f} before was foretold",
                              fit.check.largest, fit.check.limit, fit.check.joint, fit.check.joint_limit,
                              text_of(c.keys, advice.new_setting), advice.promise.old_mean);
    row.promised = advice.promise.gain;
    row.low = advice.promise.gain_interval.low;
    row.high = advice.promise.gain_interval.high;
    print_pairs(c, advice.new_setting, oracle(c), row);
    return row;
  }

  Options o_;
  std::string file_;
  Experiment base_;
  std::size_t goal_;
  LabClass lab_;
};

}  // namespace

FIRN_BENCH(tune_promises) {
  Options o;
  std::vector<std::string> kinds{"droplets"};
  std::vector<std::string> known{"droplets",  "height-change", "optimal", "mpc",
                                 "estimator", "spacing",       "ice",     "ice-foresee"};
  for (const Nature& n : kStrange) known.emplace_back(n.kind);
  CaseBench bench("tune_promises", "promises of firn tune held against prints");
  bench.options().option("LABS", o.labs, "of each kind").show_default().within(1, 1000000);
  bench.options().option("--seed", o.seed, "of the laboratories").show_default();
  bench.options()
      .option("--first", o.first, "number of the first laboratory")
      .show_default()
      .within(0, 1000000);
  bench.options()
      .option("--kind", kinds, "given several times")
      .one_value_each()
      .show_default()
      .one_of(known);
  bench.options().option("--part", o.file, "experiment whose part is printed");
  bench.options().option("--pairs", o.pairs, "of prints").show_default().within(2, 10000);
  bench.options()
      .option("--budget", o.budget, "simulated prints of an answer")
      .show_default()
      .within(300, 100000);
  if (const auto code = bench.parse(argc, argv)) return *code;
  std::vector<std::string> words{std::to_string(o.labs),  "--seed",  std::to_string(o.seed),  "--first",
                                 std::to_string(o.first), "--pairs", std::to_string(o.pairs), "--budget",
                                 std::to_string(o.budget)};
  if (!o.file.empty()) {
    o.file = std::filesystem::absolute(o.file).string();
    words.insert(words.end(), {"--part", o.file});
  }
  for (const std::string& kind : kinds) words.insert(words.end(), {"--kind", kind});
  Cases cases{"tune_promises",
              fmt::format("seed {}, {} pairs, budget {}, {}", o.seed, o.pairs, o.budget,
                          o.file.empty() ? "" : dump(load_experiment(o.file))),
              kinds,
              {},
              {}};
  cases.one_by_one = true;
  for (int n = o.first; n < o.first + o.labs; ++n) cases.seeds.push_back(std::uint64_t(n));
  cases.make = [&](std::size_t kind, std::uint64_t lab, int threads) {
    Options of_kind = o;
    of_kind.kind = kinds[kind];
    of_kind.threads = threads;
    return row_text(Bench(of_kind).row(int(lab)));
  };
  int code = 0;
  const auto results = bench.results(cases, words, code);
  if (!results) return code;
  std::vector<PromiseRow> rows;
  for (const CaseBench::Result& result : *results) {
    if (!result.made) {
      fmt::print("{}\n", result.reason);
      continue;
    }
    const PromiseRow& r = rows.emplace_back(row_of(result.text));
    fmt::print(
        "{:>4} {:<34} {:>7.3f} promised {:>7.3f} [{:>7.3f},{:>7.3f}] printed {:>7.3f} oracle {:>7.3f} {} "
        "{}\n",
        r.lab, r.keys, r.before, r.promised, r.low, r.high, r.printed, r.oracle, r.answer, r.feature);
  }
  fmt::print("{}", promise_table(rows));
  return 0;
}

}  // namespace firn::bench::tune_promises
