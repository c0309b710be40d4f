#include "cli/tune_command.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/sealed_run.h"
#include "cli/tune_lab_command.h"
#include "config/labs.h"
#include "estimators/gains/tune_smf.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/import/imported_run.h"
#include "report/draw/charts.h"
#include "report/draw/style.h"
#include "runs/folder/config_change.h"
#include "runs/folder/run_folder.h"
#include "studies/reproduce/reproduce.h"
#include "studies/tune/ice_disturbance.h"

namespace firn {
namespace {

using namespace control::smf_line;
using gains::Algorithm;
using nlohmann::ordered_json;

Algorithm algorithm_of(const std::string& text) {
  if (text == "slsqp") return Algorithm::kSlsqp;
  if (text == "lbfgs") return Algorithm::kLbfgs;
  if (text == "cobyla") return Algorithm::kCobyla;
  throw UsageError("--algorithm: '" + text + "' is none of slsqp, lbfgs, cobyla");
}

constexpr const char* kLeftOut =
    "the model is one point of the surface: neighbours, rounding to whole droplets, saturation and the "
    "sensor's "
    "noise are left out, so these gains promise nothing about a print; firn tune RUN --keys does";

struct Judged {
  std::string what;
  Gains gains;
  double rms = 0.0;
};

ordered_json judged_json(const Judged& j) {
  ordered_json z = ordered_json::array();
  for (const auto& pole : poles(j.gains)) z.push_back({pole.real(), pole.imag()});
  return {{"what", j.what},
          {"kp", j.gains.kp},
          {"ki_star", j.gains.ki_star},
          {"kd_star", j.gains.kd_star},
          {"rms_intervals", j.rms},
          {"stable", stable(j.gains)},
          {"margin", stability_margin(j.gains)},
          {"largest_pole", largest_pole(j.gains)},
          {"poles", z}};
}

// Error and action over the intervals, tuned gains and those they are compared with.
std::string picture(const std::vector<Judged>& all, const std::vector<double>& d) {
  std::vector<report::Series> errors, actions;
  for (std::size_t n = 0; n < all.size(); ++n) {
    std::vector<double> e(d.size()), u(d.size()), k(d.size());
    simulate(all[n].gains, d, e, u);
    for (std::size_t i = 0; i < d.size(); ++i) k[i] = double(i + 1);
    errors.push_back({all[n].what, k, e, int(n)});
    actions.push_back({all[n].what, k, u, int(n)});
    if (n == 0) actions.push_back({"disturbance d", k, d, report::Series::kReference});
  }
  report::ChartOptions a, b;
  a.title = "error e";
  a.x_name = "measurement interval k";
  a.y_name = "e [intervals]";
  a.whole_x = true;
  b.title = "action u";
  b.x_name = "measurement interval k";
  b.y_name = "u [of nominal]";
  b.whole_x = true;
  return "<svg viewBox=\"0 0 900 330\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><title>SMF under "
         "its disturbance</title>\n"
         "<svg x=\"0\" y=\"0\" width=\"440\" height=\"330\">" +
         report::line_chart(errors, a) + "</svg><svg x=\"450\" y=\"0\" width=\"440\" height=\"330\">" +
         report::line_chart(actions, b) + "</svg></svg>\n";
}

}  // namespace

std::vector<double> disturbance_of(const ObservedRun& run) {
  const double worth = run.prior().layer_height_mm();  // a record of others has a scale of its own
  std::vector<double> d;
  for (const droplet::PrintedLayer& layer : run.printed()) {
    double added = 0.0, droplets = 0.0;
    std::int64_t cells = 0;
    for (std::size_t c = 0; c < layer.fired.size(); ++c) {
      if (!run.mask().cells[c]) continue;
      droplets += layer.fired.cells[c];
      const double rise = layer.after.cells[c] - layer.before.cells[c];
      if (!std::isfinite(rise)) continue;
      added += rise;
      ++cells;
    }
    // A layer of less than half a droplet per cell tells of its edges more than of the process.
    if (cells && droplets >= 0.5 * double(cells))
      d.push_back((added - droplets * worth) / (worth * double(cells)));
  }
  if (d.size() < 3)
    throw UsageError("the run holds " + std::to_string(d.size()) +
                     " layers of half a droplet per cell or more with their maps; three are needed");
  return d;
}

namespace {

Experiment recorded_experiment(const std::string& run) {
  const std::string config = runs::recorded_config(runs::RunFolder::open(run).path());
  return config.empty() ? Experiment{} : parse_experiment(config, run + ": the recorded configuration");
}

std::vector<double> recorded_disturbance(const std::string& run, const Experiment& e) try {
  refuse_beads(run, "firn tune smf");
  return prints_paths(e) ? ice_disturbance_of(run) : disturbance_of(ObservedRun::read(run));
} catch (const UsageError& error) {
  const std::string what = error.what();
  throw UsageError(what.starts_with(run) ? what : run + ": " + what);
} catch (const std::invalid_argument& error) {
  throw UsageError(run + ": " + error.what());
}

}  // namespace

int run_tune_smf(const TuneCommandOptions& o) {
  if (o.start.size() != 3) throw UsageError("--start: three numbers are wanted, K_p, K_i*, K_d*");
  gains::TuneOptions tune{algorithm_of(o.algorithm), {o.start[0], o.start[1], o.start[2]}, o.derivative_only};
  std::vector<double> d;
  std::vector<Judged> all(1);
  try {
    if (o.run.empty()) {
      d = disturbance(o.model);
    } else {
      const auto still = use_sealed_run(o.run, o.unsealed);
      const Experiment e = recorded_experiment(o.run);
      d = recorded_disturbance(o.run, e);
      const auto& smf = e.control.smf;
      all.push_back({"the run's", {smf.kp, smf.ki_star, smf.kd_star}});
    }
    const gains::TunedGains t = gains::tune_smf(d, tune);
    all[0] = {"tuned", t.gains, t.rms};
    all.push_back({"thesis, 5.7", {1.0, 0.33, 0.03}});
    for (Judged& j : all) j.rms = spread(j.gains, d).rms;
    if (!o.output.empty()) write_file_atomically(o.output, report::standalone_svg(picture(all, d)));
    if (o.json) {
      ordered_json rows = ordered_json::array();
      for (const Judged& j : all) rows.push_back(judged_json(j));
      std::puts(ordered_json{{"algorithm", gains::name(tune.algorithm)},
                             {"evaluations", t.evaluations},
                             {"optimality", t.optimality},
                             {"intervals", d.size()},
                             {"disturbance", d},
                             {"left_out", kLeftOut},
                             {"gains", rows}}
                    .dump(2)
                    .c_str());
      return kOk;
    }
    fmt::print("{} intervals; {} after {} evaluations, gradient left {:.1e}\n", d.size(),
               gains::name(tune.algorithm), t.evaluations, t.optimality);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  fmt::print("{:<14} {:>9} {:>9} {:>9} {:>16} {:>8} {:>14}\n", "", "K_p", "K_i*", "K_d*", "RMS [intervals]",
             "stable", "largest pole");
  for (const Judged& j : all)
    fmt::print("{:<14} {:>9.5f} {:>9.5f} {:>9.5f} {:>16.6f} {:>8} {:>14.4f}\n", j.what, j.gains.kp,
               j.gains.ki_star, j.gains.kd_star, j.rms, stable(j.gains) ? "yes" : "no",
               largest_pole(j.gains));
  fmt::print("{}\n", kLeftOut);
  if (!o.run.empty() && d.size() < 30)
    fmt::print("the disturbance is that of {} intervals of one print\n", d.size());
  return kOk;
}

void declare_tune(OptionSet& options) {
  OptionSet smf =
      options.subcommand("smf", "gains of surface-mapping feedback that make the RMS error least");
  auto& o = smf.calls(run_tune_smf);
  smf.option("RUN", o.run, "run folder whose disturbance is taken; without it, the model below");
  auto& m = o.model;
  m.pulse = 0.5;
  m.step = 0.2;
  smf.option("--intervals", m.intervals, "measurement intervals").show_default();
  smf.option("--pulse", m.pulse, "pulse disturbance d_p [intervals]").show_default();
  smf.option("--pulse-at", m.pulse_at, "its interval k_p").show_default();
  smf.option("--step", m.step, "step disturbance d_s [intervals]").show_default();
  smf.option("--step-at", m.step_at, "its first interval k_s").show_default();
  smf.option("--random", m.random, "random disturbance d_r [intervals]").show_default();
  smf.option("--seed", m.seed, "of the random disturbance").show_default();
  smf.option("--algorithm", o.algorithm, "slsqp, lbfgs or cobyla").show_default();
  smf.option("--start", o.start, "K_p,K_i*,K_d* to start from").separated_by(',').show_default();
  smf.flag("--derivative-only", o.derivative_only, "K_p and K_i* stay at their start (5.39)");
  smf.option("-o,--output", o.output, "picture of error and action, SVG");
  declare_unsealed(smf, o.unsealed);
  smf.json_flag(o.json);
  declare_tune_lab(options);
}

}  // namespace firn
