#include "studies/tune/next_print.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "config/labs.h"
#include "core/grid/random.h"
#include "estimators/lab/layer_features.h"
#include "studies/identify/identification_study.h"

namespace firn::tune {
namespace {

constexpr std::uint32_t kNextStream = 3;

template <int kPercent>
void random_pattern(Experiment& e) {
  e.control.scheme = "pattern";
  e.control.pattern.kind = control::PatternKind::kRandom;
  e.control.pattern.fill = 0.01 * kPercent;
  e.control.pattern.layers = 12;
}
void without_feedback(Experiment& e) { e.control.scheme = "open_loop"; }
void lively(Experiment& e) {
  e.control.scheme = "smf";
  e.control.smf.kp = 1.8;
  e.control.smf.ki_star = e.control.smf.kd_star = 0.0;
}

struct Excitation {
  const char* name;
  const char* how;
  void (*set)(Experiment&);  ///< nullptr: the recorded print
};
constexpr Excitation kOfDroplets[] = {
    {"the same print again", "", nullptr},
    {"12 layers of random droplets, half of the cells",
     "--set control.scheme=pattern --set control.pattern.fill=0.5 --set control.pattern.layers=12",
     &random_pattern<50>},
    {"12 layers of random droplets, four cells of five",
     "--set control.scheme=pattern --set control.pattern.fill=0.8 --set control.pattern.layers=12",
     &random_pattern<80>},
};
constexpr Excitation kOfPaths[] = {
    {"the same print again", "", nullptr},
    {"the same part without feedback", "--set control.scheme=open_loop", &without_feedback},
    {"the same part under feedback that overcorrects",
     "--set control.scheme=smf --set control.smf.kp=1.8 --set control.smf.ki_star=0 --set "
     "control.smf.kd_star=0",
     &lively},
};

std::span<const Excitation> excitations(const Experiment& e) {
  if (prints_paths(e)) return kOfPaths;
  return kOfDroplets;
}

Experiment excited(const RecordedRun& run, const Excitation& x) {
  Experiment e = without_plant(run.experiment);
  x.set(e);
  return e;
}

/// The fit's last simulations of the first run, parameters in units of the posterior's scatter.
lab::Simulations in_posterior_units(const FittedLab& lab) {
  const lab::Simulations& from = lab.simulations;
  lab::Simulations to{from.parameters, lab::feature_count(), {}, {}};
  for (std::size_t n = 0; n < from.rows(); ++n)
    to.add(lab.posterior.normals_of({from.z.data() + n * from.parameters, from.parameters}),
           {from.s.data() + n * from.features, to.features});
  return to;
}

/// Information that one more print of the excitation adds, in units of the posterior's own scatter.
NextPrint judged(const FittedLab& lab, const Excitation& x, const lab::Simulations& sims) {
  NextPrint out{x.name, x.how, 0.0, "", 1.0};
  const std::size_t size = lab.lab->parameters.size();
  if (sims.rows() < size + 5) return out;
  // With parameters w that are standard normal now, the next posterior's covariance does not depend on the
  // observations.
  const std::vector<double> nothing(sims.features, 0.0);
  const auto next = lab::SyntheticLikelihood(sims).posterior(nothing, lab::fitted_features());
  out.information = -0.5 * next.log_determinant();
  for (std::size_t p = 0; p < size; ++p) {
    const double to = lab.posterior.std_with(next, p) / lab.posterior.std(p);
    if (to >= out.narrows_to) continue;
    out.narrows_to = to;
    out.narrows = lab.lab->parameters[p].name;
  }
  return out;
}

}  // namespace

std::vector<NextPrint> next_prints(const FittedLab& lab, const RecordedRun& run,
                                   const NextPrintOptions& options) {
  std::vector<NextPrint> out;
  double done = 0.0;
  const std::span<const Excitation> allowed = excitations(run.experiment);
  for (const Excitation& x : allowed) {
    done += 1.0 / double(allowed.size());
    if (options.progress) options.progress(done, "looking for the next print");
    if (!x.set) {
      out.push_back(judged(lab, x, in_posterior_units(lab)));
      continue;
    }
    const Experiment e = excited(run, x);
    const std::size_t size = lab.lab->parameters.size();
    std::vector<std::vector<double>> w(std::size_t(options.draws), std::vector<double>(size)), s(w.size());
    run_jobs(options.draws, options.threads, [&](int n) {
      const std::size_t at = std::size_t(n);
      RandomStream random(options.seed, Purpose::kInstance, 2000 + kNextStream, std::uint32_t(n));
      for (double& v : w[at]) v = random.normal();
      s[at] = print_in_lab(e, run.inputs, {lab.lab, lab.posterior.at(w[at]), random.bits() >> 2},
                           {.features = true, .noise = run.noise, .journal = options.journal})
                  .features;
    });
    lab::Simulations sims{size, lab::feature_count(), {}, {}};
    for (std::size_t n = 0; n < w.size(); ++n)
      if (!s[n].empty()) sims.add(w[n], s[n]);
    out.push_back(judged(lab, x, sims));
  }
  std::ranges::stable_sort(out, std::ranges::greater{}, &NextPrint::information);
  return out;
}

}  // namespace firn::tune
