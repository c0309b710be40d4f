// Promises of firn tune held against prints, over laboratories that are drawn at random. Parameters are drawn
// from the classes' own distributions; the recorded setting and the disturbances are drawn too.
//   tune_promises [LABS] [--seed S] [--first N] [--kind KIND] [--part EXPERIMENT] [--pairs N] [--budget N]
//                 [--threads N]
// KIND: droplets, height-change; optimal: droplets whose recorded setting is the oracle's, so that nothing
// can be gained; thin-film, pressure, flight, dead-row, tilted: laboratories of no class that the tuner
// knows. Without --part a cylinder of 16 x 16 cells and nine layers is printed, with 160 points a profile.
// Laboratory n of a seed is the same whatever was run before it (--first).
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "config/include.h"
#include "core/grid/random.h"
#include "estimators/lab/box_search.h"
#include "print/labs/print_labs.h"
#include "studies/identify/identification_study.h"
#include "studies/tune/advice.h"
#include "studies/tune/tune_answer.h"

using namespace firn;
using namespace firn::tuning;

namespace {

constexpr int kOracleEvaluations = 18, kOraclePrints = 5;
constexpr double kHarm = 0.02;

double cpu_s() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return double(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * double(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

// A film that levels far more than a droplet does.
void thin_film(std::span<const double>, plant::WorldConfig& w) {
  w.droplet.levelling_steps = 12;
  w.droplet.levelling = 0.25;
  w.droplet.run_share = 0.25;
}
// A line whose pressure falls by a third within a layer.
void weak_pressure(std::span<const double>, plant::WorldConfig& w) {
  w.nozzle.drift = true;
  w.nozzle.pressure_per_drop = 3e-4;
}
// Droplets that land a third of a cell ahead, the other way in every other row.
void late_flight(std::span<const double>, plant::WorldConfig& w) { w.droplet.flight_time_s = 6e-4; }
// A row in the middle of the part that gets no droplet.
void dead_row(std::span<const double>, plant::WorldConfig& w) { w.droplet.dead_row = w.grid.ny / 2; }
// A sensor that hangs askew by an eighth of a degree.
void tilted_sensor(std::span<const double>, plant::WorldConfig& w) { w.sensor.tilt = 0.0022; }

struct Nature {
  const char* kind;
  void (*set)(std::span<const double>, plant::WorldConfig&);
};
constexpr Nature kStrange[] = {
    {"thin-film", &thin_film}, {"pressure", &weak_pressure}, {"flight", &late_flight},
    {"dead-row", &dead_row},   {"tilted", &tilted_sensor},
};

std::vector<std::string> settings_of(bool small) {
  std::vector<std::string> s{"control.scheme=smf"};
  if (small)
    for (const char* set : {"grid.nx=16", "grid.ny=16", "part.diameter_mm=3.7", "part.height_mm=0.07",
                            "laser_profiler.points=160", "process.scan_speed_mm_s=15.0"})
      s.emplace_back(set);
  return s;
}

struct Case {
  LabDraw lab;
  Experiment experiment;
};

struct Options {
  std::string file, kind = "droplets";
  std::uint64_t seed = 1;
  int labs = 10, first = 0, threads = 2, pairs = 10, budget = 420;
};

class Bench {
 public:
  explicit Bench(const Options& o)
      : o_(o),
        file_(o.file.empty() ? FIRN_SOURCE_DIR "/experiments/demo.toml" : o.file),
        base_(load_experiment(file_, settings_of(o.file.empty()))),
        inputs_(make_inputs(base_, std::filesystem::path(file_).parent_path())),
        lab_(lab_classes()[o.kind == "height-change" ? 1 : 0]) {
    for (const Nature& n : kStrange)
      if (o.kind == n.kind) lab_.nature = n.set;
  }

  void run() {
    fmt::print("{:>4} {:>14} {:>7} {:>22} {:>7} {:>7} {:>17} {:>7} {:>7} {}\n", "lab", "kp, ki_star", "true",
               "advice", "gain", "oracle", "promised", "printed", "check", "answer");
    for (int n = o_.first; n < o_.first + o_.labs; ++n) one(n);
    const auto share = [](int part, int all) { return all ? 100.0 * part / all : NAN; };
    fmt::print(
        "{}: {} labs, {} refused by the check, {} with nothing to gain, {} advised\n"
        "promises that cover the printed gain: {} of {} ({:.0f} %)\n"
        "advice that printed worse by more than {:.0f} %: {} of {}\n"
        "gain of the advised and of those told to keep, over the oracle's: {:.0f} %\n"
        "processor time of an answer: {:.1f} s\n",
        o_.kind, answered_ + refused_, refused_, answered_ - advised_, advised_, covered_, answered_,
        share(covered_, answered_), 100 * kHarm, harmed_, advised_, 100.0 * gained_ / possible_,
        cpu_s_ / std::max(1, answered_ + refused_));
  }

 private:
  std::vector<TuneKey> keys_of(const Experiment& e) const {
    return {{"control.smf.kp", e}, {"control.smf.ki_star", e}};
  }

  /// NaN for a print that does not finish.
  std::vector<double> goals(const Experiment& e, const LabDraw& lab, std::uint32_t stream, int prints) const {
    std::vector<double> goal(std::size_t(prints), 0.0);
    run_jobs(prints, o_.threads, [&](int n) {
      LabDraw draw = lab;
      draw.seed = print_seed({lab.seed, Purpose::kTest, stream, 0, std::uint32_t(n)});
      const LabPrint print = print_in_lab(e, inputs_, draw, {});
      goal[std::size_t(n)] = print.finished ? print.metrics[0] : NAN;
    });
    return goal;
  }

  /// Mean over the prints that finish; a setting with which others stop is no candidate of the oracle.
  double oracle_goal(const Experiment& e, const LabDraw& lab) const {
    double sum = 0.0;
    int finished = 0;
    for (const double g : goals(e, lab, 1, kOraclePrints)) {
      if (std::isnan(g)) continue;
      sum += g;
      ++finished;
    }
    return 2 * finished > kOraclePrints ? sum / finished : 1e3;
  }

  struct Printed {
    double before = 0.0, after = 0.0, with_oracle = 0.0;
    int stopped_before = 0, stopped_after = 0;
  };
  /// Over the pairs of which all finish.
  Printed printed(const Case& c, const Setting& advice, const Setting& best) const {
    const auto keys = keys_of(c.experiment);
    const Experiment plain = without_plant(c.experiment);
    const auto a = goals(plain, c.lab, 2, o_.pairs),
               b = goals(with_setting(keys, advice, plain), c.lab, 2, o_.pairs),
               o = goals(with_setting(keys, best, plain), c.lab, 2, o_.pairs);
    Printed p;
    double whole = 0.0;
    for (std::size_t n = 0; n < a.size(); ++n) {
      p.stopped_before += std::isnan(a[n]);
      p.stopped_after += std::isnan(b[n]);
      if (std::isnan(a[n] + b[n] + o[n])) continue;
      whole += 1.0;
      p.before += a[n];
      p.after += b[n];
      p.with_oracle += o[n];
    }
    p.before /= whole;
    p.after /= whole;
    p.with_oracle /= whole;
    return p;
  }

  /// The best setting that a search in the laboratory itself finds.
  Setting oracle(const Case& c) const {
    const auto keys = keys_of(c.experiment);
    const Experiment plain = without_plant(c.experiment);
    const auto setting_at = [&](std::span<const double> u) {
      return Setting{keys[0].at(u[0]), keys[1].at(u[1])};
    };
    const std::vector<double> start{keys[0].place(keys[0].recorded()), keys[1].place(keys[1].recorded())};
    const auto points = lab::minimise_in_box(
        [&](std::span<const double> u) {
          return oracle_goal(with_setting(keys, setting_at(u), plain), c.lab);
        },
        start, kOracleEvaluations);
    return setting_at(std::ranges::min_element(points, {}, &lab::BoxPoint::value)->u);
  }

  Case draw(int n) const {
    RandomStream random(o_.seed, Purpose::kTest, std::uint32_t(n), 77);
    Case c{{&lab_, {}, random.bits() >> 2}, base_};
    for (std::size_t p = 0; p < lab_.parameters.size(); ++p) c.lab.z.push_back(random.normal());
    c.experiment.control.smf.kp = random.uniform(0.3, 1.4);
    c.experiment.control.smf.ki_star = random.uniform(0.0, 0.6);
    c.experiment.control.smf.kd_star = 0.0;
    return c;
  }

  void one(int n) {
    Case c = draw(n);
    const bool optimal = o_.kind == "optimal";
    if (optimal) {
      const Setting best = oracle(c);
      c.experiment.control.smf.kp = best[0];
      c.experiment.control.smf.ki_star = best[1];
    }
    const LabPrint log = print_in_lab(without_plant(c.experiment), inputs_, c.lab, {.features = true});
    if (log.features.empty()) {
      fmt::print("{:>4} the print does not finish: {}\n", n, log.reason);
      return;
    }
    const double began = cpu_s();
    const std::vector<RecordedRun> runs{{"lab", c.experiment, inputs_, log.features, 0}};
    const int fit_prints = int(0.41 * o_.budget);
    const std::uint64_t seed = o_.seed + std::uint64_t(n);
    const FittedLab fit = fit_lab(runs, {.seed = seed, .threads = o_.threads, .prints = fit_prints});
    if (!fit.check.passed()) {
      cpu_s_ += cpu_s() - began;
      ++refused_;
      const auto& worst = fit.check.missed.front();
      fmt::print("{:>4} refused: {} ({:+.1f})\n", n, worst.feature, worst.deviation);
      std::fflush(stdout);
      return;
    }
    const auto keys = keys_of(c.experiment);
    const Advice advice = advise(
        fit, runs[0], keys,
        {.seed = seed, .threads = o_.threads, .prints = o_.budget - fit_prints, .promised_prints = o_.pairs});
    cpu_s_ += cpu_s() - began;
    judge(n, c, fit, advice);
  }

  void judge(int n, const Case& c, const FittedLab& fit, const Advice& advice) {
    const Promise& p = advice.promise;
    const Printed printed = this->printed(c, advice.new_setting, oracle(c));
    const double before = printed.before, after = printed.after, of_oracle = printed.with_oracle;
    const double gain = before - after;
    ++answered_;
    covered_ += gain >= p.gain_interval.low && gain <= p.gain_interval.high;
    advised_ += advice.gain_shown;
    harmed_ += advice.gain_shown &&
               (after > before * (1.0 + kHarm) || printed.stopped_after > printed.stopped_before);
    gained_ += advice.gain_shown ? gain : 0.0;
    possible_ += std::max(0.0, before - of_oracle);
    fmt::print(
        "{:>4} {:>6.2f}, {:>6.3f} {:>7.3f} {:>10.2f}, {:>10.3f} {:>7.3f} {:>7.3f} [{:>7.3f},{:>7.3f}] "
        "{:>7.3f} "
        "{:>4.1f}/{:.1f} {}\n",
        n, c.experiment.control.smf.kp, c.experiment.control.smf.ki_star, before, advice.new_setting[0],
        advice.new_setting[1], p.gain, before - of_oracle, p.gain_interval.low, p.gain_interval.high, gain,
        fit.check.largest, fit.check.limit, advice.gain_shown ? "advised" : "nothing to gain");
    std::fflush(stdout);
  }

  Options o_;
  std::string file_;
  Experiment base_;
  Blobs inputs_;
  LabClass lab_;
  int answered_ = 0, refused_ = 0, advised_ = 0, covered_ = 0, harmed_ = 0;
  double gained_ = 0.0, possible_ = 0.0, cpu_s_ = 0.0;
};

}  // namespace

int main(int argc, char** argv) {
  Options o;
  for (int n = 1; n < argc; ++n) {
    const std::string a = argv[n];
    const bool more = n + 1 < argc;
    if (a == "--seed" && more)
      o.seed = std::strtoull(argv[++n], nullptr, 10);
    else if (a == "--kind" && more)
      o.kind = argv[++n];
    else if (a == "--first" && more)
      o.first = std::max(0, std::atoi(argv[++n]));
    else if (a == "--part" && more)
      o.file = argv[++n];
    else if (a == "--threads" && more)
      o.threads = std::max(1, std::atoi(argv[++n]));
    else if (a == "--pairs" && more)
      o.pairs = std::max(2, std::atoi(argv[++n]));
    else if (a == "--budget" && more)
      o.budget = std::max(300, std::atoi(argv[++n]));
    else
      o.labs = std::max(1, std::atoi(a.c_str()));
  }
  if (o.kind != "droplets" && o.kind != "height-change" && o.kind != "optimal" &&
      std::ranges::none_of(kStrange, [&](const Nature& n) { return o.kind == n.kind; })) {
    fmt::print(stderr, "--kind {}: no such kind of laboratory\n", o.kind);
    return 2;
  }
  Bench(o).run();
  return 0;
}
