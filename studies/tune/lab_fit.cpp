#include "studies/tune/lab_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <string_view>

#include "core/grid/random.h"
#include "estimators/lab/layer_features.h"
#include "files/usage_error.h"
#include "studies/identify/identification_study.h"

namespace firn::tune {
namespace {

using lab::Normal;
using lab::Simulations;
using lab::SyntheticLikelihood;

constexpr double kFarthest = 3.5;              // |z| of any draw
constexpr double kWiden[] = {1.0, 1.6, 1.25};  // draws of a round over the posterior of the round before
constexpr double kMinLimit = 4.5;              // standard deviations, over some hundred features
constexpr double kBeyondDraws = 1.1;           // times the largest deviation of any simulated print
constexpr double kMaxDeviation = 99.0;         // of a feature that no simulation or hardly any moves
constexpr double kUnusual = 3.0;               // standard deviations of the sum of squared parameters
constexpr double kJointly = 1.3;               // times the largest joint deviation of any simulated print
constexpr double kEarlyShare = 0.62;           // of the prints, for the rounds of all classes
constexpr int kMinEarly = 28;                  // prints of a round
constexpr double kLastShare = 0.26;            // of the prints, for the last round
constexpr int kMinLast = 44;                   // its prints
// Times the classes' own scatter, for the last posterior: a laboratory at the far end of its class would else
// be pulled towards the usual ones by more than its interval is wide.
constexpr double kDoubt = 1.5;
constexpr std::size_t kSpareRows = 8;  // finished prints beyond the number of parameters
constexpr int kMayFail = 2;            // prints more than that number
constexpr double kHopeless = 100.0;    // nats behind the best class
constexpr double kFarBehind = 300.0;   // the same after hardly more prints than a regression needs
constexpr double kImpossible = -1e9;   // score of a class of which hardly any print finishes
constexpr std::uint32_t kFitStream = 0;

std::vector<double> normals(std::uint64_t seed, std::uint32_t stream, std::uint32_t n, std::size_t count) {
  RandomStream random(seed, Purpose::kInstance, stream, n);
  std::vector<double> out(count);
  for (double& v : out) v = random.normal();
  return out;
}

std::vector<double> held(std::vector<double> z) {
  for (double& v : z) v = std::clamp(v, -kFarthest, kFarthest);
  return z;
}

std::vector<std::size_t> of_all_runs(const std::vector<std::size_t>& features, std::size_t runs) {
  std::vector<std::size_t> out;
  for (std::size_t r = 0; r < runs; ++r)
    for (const std::size_t f : features) out.push_back(r * lab::feature_count() + f);
  return out;
}

class Fit {
 public:
  Fit(std::span<const RecordedRun> runs, const FitOptions& options)
      : runs_(runs),
        options_(options),
        deposition_(lab_of(runs.front().experiment).deposition),
        classes_(lab_classes(deposition_)) {
    for (const RecordedRun& r : runs) {
      if (lab_of(r.experiment).deposition != deposition_)
        throw UsageError(r.name + ": its lab is of another kind than that of " + runs.front().name);
      observed_.insert(observed_.end(), r.features.begin(), r.features.end());
      experiments_.push_back(without_plant(r.experiment));
    }
  }

  FittedLab run() {
    const int classes = int(classes_.size());
    const int early = std::max(kMinEarly, int(kEarlyShare * options_.prints / (2 * classes)));
    const int last = std::max(kMinLast, int(kLastShare * options_.prints));
    all_ = double(2 * classes * early + last);
    std::vector<FittedLab> fits(classes_.size());
    std::vector<ClassScore> scores;
    for (std::size_t c = 0; c < fits.size(); ++c) {
      fits[c].lab = &classes_[c];
      fits[c].posterior = lab::standard_normal(classes_[c].parameters.size());
      fits[c].simulations = {classes_[c].parameters.size(), observed_.size(), {}, {}};
      scores.push_back({classes_[c].name, 0.0});
    }
    // A class that is hopeless gets no more prints: first by hardly enough of them, then after each round.
    if (classes > 1)
      for (std::size_t c = 0; c < fits.size(); ++c) {
        simulate(fits[c], 0, 0, min_prints(fits[c]));
        scores[c].log_predictive = enough(fits[c]) ? held_out_score(fits[c]) : kImpossible;
      }
    double least = best_of(scores).log_predictive - kFarBehind;
    for (std::size_t c = 0; c < fits.size(); ++c) {
      if (scores[c].log_predictive < least && scores[c].log_predictive > kImpossible) continue;
      const int before = classes > 1 ? min_prints(fits[c]) : 0;
      simulate(fits[c], 0, before, early);
      scores[c].log_predictive = narrow(fits[c]) ? held_out_score(fits[c]) : kImpossible;
    }
    least = best_of(scores).log_predictive - kHopeless;
    for (std::size_t c = 0; c < fits.size(); ++c)
      if (scores[c].log_predictive >= least) {
        fits[c].simulations.clear();
        simulate(fits[c], 1, 0, early);
        scores[c].log_predictive = narrow(fits[c]) ? held_out_score(fits[c]) : kImpossible;
      }
    const ClassScore& highest = best_of(scores);
    FittedLab best = std::move(fits[std::size_t(&highest - scores.data())]);
    const int kept = keep_near(best, 2, last);
    simulate(best, 2, 0, std::max(last / 2, last - kept));
    if (!narrow(best, kDoubt))
      throw UsageError("hardly any print of the simulated laboratories finishes: " + reason_);
    best.scores = std::move(scores);
    best.observed = observed_;
    best.prints = prints_;
    best.failed = failed_;
    best.check = check(best);
    return best;
  }

 private:
  static const ClassScore& best_of(const std::vector<ClassScore>& scores) {
    return *std::ranges::max_element(scores, {}, &ClassScore::log_predictive);
  }

  static int min_prints(const FittedLab& fit) {
    return int(fit.lab->parameters.size() + kSpareRows) + kMayFail;
  }

  std::uint32_t stream_of(const FittedLab& fit, int round) const {
    return kFitStream + 16u * std::uint32_t(fit.lab - classes_.data()) + std::uint32_t(round);
  }

  /// Adds prints [first, last) of a round, with draws of the posterior so far.
  void simulate(FittedLab& fit, int round, int first, int last) {
    const std::size_t parameters = fit.lab->parameters.size(), features = observed_.size();
    const int prints = std::max(0, last - first);
    std::vector<std::vector<double>> z(std::size_t(prints), std::vector<double>{}), s = z;
    const std::uint32_t stream = stream_of(fit, round);
    run_jobs(prints, options_.threads, [&](int job) {
      const std::size_t at = std::size_t(job);
      const auto n = std::uint32_t(first + job);
      z[at] = held(fit.posterior.at(normals(options_.seed, stream, n, parameters), kWiden[round]));
      for (std::size_t r = 0; r < runs_.size(); ++r) {
        const std::uint64_t seed =
            print_seed({options_.seed, Purpose::kInstance, stream, n, std::uint32_t(1000 + r)});
        const LabPrint print =
            print_in_lab(experiments_[r], runs_[r].inputs, {fit.lab, z[at], seed},
                         {.features = true, .noise = runs_[r].noise, .journal = options_.journal});
        if (print.features.empty()) {
          const std::lock_guard hold(lock_);
          ++failed_;
          s[at].clear();
          // The same words whichever thread came first.
          if (reason_.empty() || print.reason < reason_) reason_ = print.reason;
          break;
        }
        s[at].insert(s[at].end(), print.features.begin(), print.features.end());
      }
      const std::lock_guard hold(lock_);
      ++prints_;
      if (options_.progress) options_.progress(std::min(1.0, prints_ / all_), "learning the laboratory");
    });
    for (std::size_t n = 0; n < z.size(); ++n)
      if (s[n].size() == features) fit.simulations.add(z[n], s[n]);
  }

  /// Keeps of the simulations those whose parameters lie no farther out than the draws of the next round
  /// will. @returns their number
  int keep_near(FittedLab& fit, int next, int prints) const {
    const lab::Simulations from = std::move(fit.simulations);
    fit.simulations = {from.parameters, from.features, {}, {}};
    const auto square = [](std::span<const double> v) {
      return std::inner_product(v.begin(), v.end(), v.begin(), 0.0);
    };
    double farthest = 0.0;
    for (int n = 0; n < prints; ++n)
      farthest = std::max(
          farthest, square(normals(options_.seed, stream_of(fit, next), std::uint32_t(n), from.parameters)));
    farthest *= kWiden[next] * kWiden[next];
    for (std::size_t n = 0; n < from.rows(); ++n) {
      const std::span<const double> z{from.z.data() + n * from.parameters, from.parameters};
      if (square(fit.posterior.normals_of(z)) <= farthest)
        fit.simulations.add(z, {from.s.data() + n * from.features, from.features});
    }
    return int(fit.simulations.rows());
  }

  static bool enough(const FittedLab& fit) {
    return fit.simulations.rows() >= fit.simulations.parameters + kSpareRows;
  }

  /// Narrows the posterior by the simulations. @returns false where too few prints finished
  bool narrow(FittedLab& fit, double prior_std = 1.0) const {
    if (!enough(fit)) return false;
    const SyntheticLikelihood likelihood(fit.simulations);
    fit.posterior =
        likelihood.posterior(observed_, of_all_runs(lab::fitted_features(), runs_.size()), prior_std);
    fit.posterior.mean = held(fit.posterior.mean);
    return true;
  }

  double held_out_score(const FittedLab& fit) const {
    const SyntheticLikelihood likelihood(fit.simulations);
    std::vector<std::size_t> seen = lab::features_of_stretch(0);
    for (int s = 1; s + 1 < lab::kStretches; ++s) {
      const auto more = lab::features_of_stretch(s);
      seen.insert(seen.end(), more.begin(), more.end());
    }
    const Normal from_seen = likelihood.posterior(observed_, of_all_runs(seen, runs_.size()));
    return likelihood.log_predictive(
        observed_, of_all_runs(lab::features_of_stretch(lab::kStretches - 1), runs_.size()), from_seen);
  }

  FitCheck check(const FittedLab& fit) const {
    const SyntheticLikelihood likelihood(fit.simulations);
    const auto checked = of_all_runs(lab::checked_features(), runs_.size());
    const auto draws = likelihood.largest_deviations(checked);
    auto deviations = likelihood.deviations(observed_, fit.posterior);
    for (double& d : deviations) d = std::clamp(d, -kMaxDeviation, kMaxDeviation);
    FitCheck out;
    out.limit = std::max(kMinLimit, kBeyondDraws * *std::ranges::max_element(draws));
    for (const std::size_t f : checked) {
      if (likelihood.moved(f)) out.largest = std::max(out.largest, std::abs(deviations[f]));
      if (std::abs(deviations[f]) <= out.limit) continue;
      const std::string of_run = runs_.size() > 1 ? " (" + runs_[f / lab::feature_count()].name + ")" : "";
      out.missed.push_back({named(f % lab::feature_count()) + of_run, deviations[f], !likelihood.moved(f)});
    }
    const auto of_draws = likelihood.joint_deviations(checked);
    out.joint = likelihood.joint_deviation(observed_, checked, fit.posterior);
    out.joint_limit = kJointly * *std::ranges::max_element(of_draws);
    if (out.joint > out.joint_limit && out.missed.empty()) {
      const std::size_t most =
          *std::ranges::max_element(checked, {}, [&](std::size_t f) { return std::abs(deviations[f]); });
      out.missed.push_back(
          {"all features together, most the " + named(most % lab::feature_count()), deviations[most]});
    }
    miss_usual(fit, out);
    std::ranges::stable_sort(out.missed, std::ranges::greater{},
                             [](const FitCheck::Missed& m) { return std::abs(m.deviation); });
    return out;
  }

  /// A laboratory of no known class may be reproduced by parameters that hardly any laboratory has. The sum
  /// of squares of n usual ones has mean n and variance 2 n.
  static void miss_usual(const FittedLab& fit, FitCheck& out) {
    const std::vector<double>& z = fit.posterior.mean;
    const double n = double(z.size());
    double sum = 0.0;
    for (const double v : z) sum += v * v;
    const double deviation = (sum - n) / std::sqrt(2.0 * n);
    if (deviation <= kUnusual) return;
    const auto farthest = std::ranges::max_element(z, {}, [](double v) { return std::abs(v); });
    const LabParameter& p = fit.lab->parameters[std::size_t(farthest - z.begin())];
    out.missed.push_back({fmt::format("parameters of usual laboratories (most {} = {:.3g}{}{})", p.name,
                                      p.value(*farthest), p.unit.empty() ? "" : " ", p.unit),
                          deviation});
  }

  /// An ice print's units of growth are called by their name.
  std::string named(std::size_t feature) const {
    std::string name = lab::feature_name(feature);
    if (deposition_ != Deposition::kPaths) return name;
    constexpr std::string_view kWord = "droplet", kUnit = "unit of growth";
    for (std::size_t at = name.find(kWord); at != std::string::npos; at = name.find(kWord, at + kUnit.size()))
      name.replace(at, kWord.size(), kUnit);
    return name;
  }

  std::span<const RecordedRun> runs_;
  const FitOptions& options_;
  Deposition deposition_;
  std::span<const LabClass> classes_;
  std::vector<Experiment> experiments_;
  std::vector<double> observed_;
  double all_ = 1.0;
  std::mutex lock_;
  int prints_ = 0, failed_ = 0;
  std::string reason_;
};

}  // namespace

LabDraw FittedLab::draw(std::uint64_t seed, std::uint32_t stream, std::uint32_t n) const {
  const std::uint32_t own = 1000 + stream;  // no draw of the fit
  return {lab, held(posterior.at(normals(seed, own, n, lab->parameters.size()))),
          print_seed({seed, Purpose::kInstance, own, n, 1000})};
}

FittedLab fit_lab(std::span<const RecordedRun> runs, const FitOptions& options) {
  return Fit(runs, options).run();
}

}  // namespace firn::tune
