#include "studies/tune/advice.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "config/error.h"
#include "core/grid/random.h"
#include "core/statistics/distributions.h"
#include "estimators/lab/box_search.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "studies/compare/study_lab.h"
#include "studies/identify/identification_study.h"

namespace firn::tune {
namespace {

constexpr int kSearchDraws = 6, kProfileDraws = 2, kPromiseSeeds = 2;
// After each batch a candidate leaves the race whose mean logarithm over the best one's goals on the same
// draws lies so many standard errors above an improvement that is not worth a print. The scatter of few
// logarithms is taken together with a usual one.
constexpr int kBatch = 2;
constexpr double kLeaves = 1.6, kNotWorth = 0.01;
constexpr double kUsualScatter = 0.05, kUsualWeight = 2.0;
// Draws of the promise: first so many, then more where a standard error or two decide.
constexpr int kFirstDraws = 8, kMoreDraws = 4, kMayStop = 2;
constexpr double kDecided = 3.0;
constexpr std::uint32_t kSearchStream = 1, kPromiseStream = 2;
constexpr int kMaxCombinations = 24;
constexpr double kUnsafe = 1e6;  // a goal beyond any print's

// Limits are so many times the recorded setting's own value, and so much more.
constexpr double kTimes = 1.25, kSaturatedMore = 0.05, kOverspillMore = 0.01;
constexpr double kSwingMore = 0.05, kAlternates = -0.5;

constexpr std::size_t kStd = 1, kAbsMean = 2;  // rows of the metrics of either lab

struct Mean {
  double sum = 0.0, squares = 0.0;
  int n = 0;
  void add(double v) {
    sum += v;
    squares += v * v;
    ++n;
  }
  double mean() const { return n ? sum / n : 0.0; }
  double variance() const { return n > 1 ? std::max(0.0, (squares - sum * sum / n) / (n - 1)) : 0.0; }
};

/// Returns the broken rule of "the setting SETTING:LINE: RULE", without the setting's own name before it.
std::string rule_of(const std::string& error, const std::string& setting) {
  const std::string head = "the setting " + setting + ":", again = setting + ": ";
  if (!error.starts_with(head)) return error;
  const std::size_t line = error.find(": ", head.size());
  const std::string rule = line == std::string::npos ? error : error.substr(line + 2);
  return rule.starts_with(again) ? rule.substr(again.size()) : rule;
}

/// Mean over prints of one setting.
struct Outcome {
  double goal = 0.0, std_error = 0.0;
  std::vector<double> goals;  ///< of each draw; NaN: not finished
  PrintTraits traits;
  int stopped = 0;     ///< prints that did not finish
  std::string unsafe;  ///< why it is left out
  bool left = false;   ///< the race
};

class Adviser {
 public:
  Adviser(const FittedLab& lab, const RecordedRun& run, std::span<const TuneKey> keys,
          const AdviceOptions& options)
      : lab_(lab), run_(run), keys_(keys), options_(options), base_(without_plant(run.experiment)) {
    const double scale = double(options.prints) / 250.0;
    for (const TuneKey& k : keys) free_ += k.enumerated() ? 0 : 1;
    // Goals over the spacing are jagged: a step of it adds a row of cells or a layer.
    const bool jagged = std::ranges::any_of(keys, &TuneKey::spacing);
    const int usual = free_ == 0 ? 1 : free_ == 1 ? (jagged ? 28 : 14) : free_ == 2 ? 22 : 12 * free_;
    evaluations_ = std::max(free_ == 0 ? 1 : 8, int(usual * scale));
    promise_draws_ = std::max(12, int(16 * scale));
    const int candidates = evaluations_ * int(combinations().size());
    expected_ = double(kSearchDraws * (1 + candidates) / 2 + 4 * kProfileDraws * free_ +
                       kPromiseSeeds * (kFirstDraws + promise_draws_));
  }

  Advice run() {
    if (lab_.lab->one_spacing && std::ranges::any_of(keys_, &TuneKey::spacing))
      throw UsageError(
          fmt::format("--keys {}: the laboratory of these logs ({}) is known at their spacing alone",
                      kSpacing, lab_.lab->meaning));
    advice_.old_setting = recorded_setting(keys_);
    recorded_ = outcome(advice_.old_setting, Place::kRecorded);
    if (!recorded_.unsafe.empty())
      throw UsageError(run_.name + ": the recorded setting does not print in the estimated laboratory: " +
                       recorded_.unsafe);
    search();
    profiles();
    promise();
    advice_.prints = prints_;
    return std::move(advice_);
  }

 private:
  /// Prints of draws [first, first + draws), [draw * seeds + seed].
  std::vector<LabPrint> print_all(const Setting& setting, std::uint32_t stream, int first, int draws,
                                  int seeds) {
    const Experiment e = with_setting(keys_, setting, base_);
    const Blobs own = e.grid == base_.grid ? Blobs() : make_inputs(full_product(), e, ".");
    const Blobs& inputs = own.empty() ? run_.inputs : own;
    std::vector<LabPrint> out(std::size_t(draws * seeds));
    run_jobs(draws * seeds, options_.threads, [&](int n) {
      LabDraw draw = lab_.draw(options_.seed, stream, std::uint32_t(first + n / seeds));
      draw.seed = print_seed({draw.seed, Purpose::kInstance, 0, 0, std::uint32_t(n % seeds)});
      out[std::size_t(n)] = print_in_lab(e, inputs, draw, {.journal = options_.journal});
    });
    prints_ += draws * seeds;
    if (options_.progress) options_.progress(std::min(1.0, prints_ / expected_), "searching");
    return out;
  }

  double goal_of(const LabPrint& p) const {
    return p.finished && !p.metrics.empty() ? p.metrics[options_.goal] : NAN;
  }

  /// Goals over the best setting's on the same draws, which order candidates more surely than the goals
  /// themselves: a difficult laboratory is difficult for both.
  struct OverBest {
    Mean log;            ///< of each draw
    double whole = 1.0;  ///< of the sums
    double std_error() const {
      const double squares = log.variance() * std::max(0, log.n - 1);
      return std::sqrt((squares + kUsualWeight * kUsualScatter * kUsualScatter) /
                       ((kUsualWeight + log.n - 1) * std::max(1, log.n)));
    }
    bool leaves() const { return log.n >= kBatch && log.mean() + kNotWorth > kLeaves * std_error(); }
  };
  OverBest over_best(std::span<const double> goals) const {
    OverBest o;
    double sum = 0.0, best = 0.0;
    for (std::size_t n = 0; n < goals.size(); ++n) {
      const double r = goals[n] / best_goals_[n];
      if (!std::isfinite(r) || r <= 0.0) continue;
      o.log.add(std::log(r));
      sum += goals[n];
      best += best_goals_[n];
    }
    if (best > 0.0) o.whole = sum / best;
    return o;
  }

  /// Setting's place in the search: the recorded one is printed in all laboratories, a candidate until it is
  /// clearly worse, one of a profile in some.
  enum class Place { kRecorded, kCandidate, kProfile };

  Outcome outcome(const Setting& setting, Place place) {
    Outcome o;
    const int most = place == Place::kProfile ? kProfileDraws : kSearchDraws;
    int printed = 0;
    while (printed < most && o.unsafe.empty()) {
      const int batch = place == Place::kCandidate ? std::min(kBatch, most - printed) : most;
      try {
        for (const LabPrint& p : print_all(setting, kSearchStream, printed, batch, 1)) take(p, place, o);
      } catch (const ConfigError& error) {
        o.unsafe = rule_of(error.what(), text_of(keys_, setting));
        return o;
      }
      printed += batch;
      if (place != Place::kCandidate) continue;
      o.left = over_best(o.goals).leaves();
      if (o.left) break;
    }
    finish(o, place, printed);
    return o;
  }

  void take(const LabPrint& p, Place place, Outcome& o) const {
    o.goals.push_back(goal_of(p));
    if (!std::isfinite(o.goals.back())) {
      ++o.stopped;
      if (o.stopped > (place == Place::kRecorded ? kSearchDraws / 2 : recorded_.stopped))
        o.unsafe = "does not finish: " + p.reason;
      return;
    }
    o.traits.saturated += p.traits.saturated;
    o.traits.alternation += p.traits.alternation;
    o.traits.swing += p.traits.swing;
    o.traits.overspill += p.traits.overspill;
  }

  /// Means from sums.
  void finish(Outcome& o, Place place, int printed) const {
    for (double* t : {&o.traits.saturated, &o.traits.alternation, &o.traits.swing, &o.traits.overspill})
      *t /= std::max(1, printed);
    Mean goal;
    if (place == Place::kRecorded) {
      for (const double g : o.goals)
        if (std::isfinite(g)) goal.add(g);
      o.goal = goal.mean();
      return;
    }
    const OverBest over = over_best(o.goals);
    o.goal = best_ * over.whole;
    o.std_error = best_ * over.std_error();
    if (o.unsafe.empty()) o.unsafe = unsafe_trait(o.traits, recorded_.traits);
  }

  /// All values of the enumerated keys; the free ones at their recorded value.
  std::vector<Setting> combinations() const {
    std::vector<Setting> all{recorded_setting(keys_)};
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      if (!keys_[k].enumerated()) continue;
      std::vector<Setting> more;
      for (const Setting& s : all)
        for (const double v : keys_[k].values()) {
          more.push_back(s);
          more.back()[k] = v;
        }
      all = std::move(more);
      if (int(all.size()) > kMaxCombinations)
        throw UsageError(
            fmt::format("--keys: words and integers have more than {} combinations", kMaxCombinations));
    }
    return all;
  }

  Setting setting_at(const Setting& combination, std::span<const double> u) const {
    Setting s = combination;
    std::size_t n = 0;
    for (std::size_t k = 0; k < keys_.size(); ++k)
      if (!keys_[k].enumerated()) s[k] = keys_[k].at(u[n++]);
    return s;
  }

  double evaluate(const Setting& setting) {
    const auto known = evaluated_.find(setting);
    if (known != evaluated_.end()) return known->second;
    ++advice_.evaluations;
    const Outcome o = setting == advice_.old_setting ? recorded_ : outcome(setting, Place::kCandidate);
    if (!o.unsafe.empty()) advice_.rejected.push_back({text_of(keys_, setting), o.unsafe});
    // One that left is no better, whatever the sum of the draws that it was printed on.
    const double value = !o.unsafe.empty() ? kUnsafe : o.left ? std::max(o.goal, best_) : o.goal;
    evaluated_[setting] = value;
    if (value < best_) {
      best_ = value;
      best_goals_ = o.goals;
      advice_.new_setting = setting;
    }
    return value;
  }

  void search() {
    best_ = recorded_.goal;
    best_goals_ = recorded_.goals;
    advice_.new_setting = advice_.old_setting;
    std::vector<double> start;
    for (std::size_t k = 0; k < keys_.size(); ++k)
      if (!keys_[k].enumerated()) start.push_back(keys_[k].place(advice_.old_setting[k]));
    for (const Setting& c : combinations())
      lab::minimise_in_box([&](std::span<const double> u) { return evaluate(setting_at(c, u)); }, start,
                           evaluations_);
  }

  void profiles() {
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      if (keys_[k].enumerated()) continue;
      Profile p{k, {}, {}, {}, advice_.new_setting[k], advice_.new_setting[k]};
      const double centre = keys_[k].place(advice_.new_setting[k]);
      std::vector<double> places{centre};
      for (const double step : {0.07, 0.18})
        for (const double u : {centre - step, centre + step})
          if (u >= 0.0 && u <= 1.0) places.push_back(u);
      std::ranges::sort(places);
      for (const double u : places) {
        Setting s = advice_.new_setting;
        if (u != centre) s[k] = keys_[k].at(u);
        if (!p.value.empty() && p.value.back() == s[k]) continue;
        Outcome o;
        if (s == advice_.new_setting)
          o.goal = best_;
        else
          o = outcome(s, Place::kProfile);
        p.value.push_back(s[k]);
        p.mean.push_back(o.unsafe.empty() ? o.goal : std::numeric_limits<double>::quiet_NaN());
        p.std_error.push_back(o.std_error);
        if (!o.unsafe.empty() || o.goal > best_ * (1.0 + kFlat)) continue;
        p.flat_low = std::min(p.flat_low, s[k]);
        p.flat_high = std::max(p.flat_high, s[k]);
      }
      advice_.profiles.push_back(std::move(p));
    }
  }

  /// Goals of the promise's draws, [draw * seeds + seed].
  struct Pairs {
    std::vector<double> old_goal, new_goal;
    Mean mean_part, all_part;
    int stopped_more = 0;
  };

  /// Prints draws [first, last) with the old and the new setting.
  void print_pairs(int first, int last, Pairs& pairs) {
    const int draws = last - first;
    const auto old_prints = print_all(advice_.old_setting, kPromiseStream, first, draws, kPromiseSeeds);
    const auto new_prints = print_all(advice_.new_setting, kPromiseStream, first, draws, kPromiseSeeds);
    for (int d = 0; d < draws; ++d) {
      double a[kPromiseSeeds], b[kPromiseSeeds];
      bool whole = true;
      for (int s = 0; s < kPromiseSeeds; ++s) {
        const std::size_t n = std::size_t(d * kPromiseSeeds + s);
        const LabPrint &o = old_prints[n], &w = new_prints[n];
        pairs.stopped_more += int(!w.finished) - int(!o.finished);
        whole = whole && o.finished && w.finished && !o.metrics.empty() && !w.metrics.empty() &&
                std::isfinite(o.metrics[options_.goal]) && std::isfinite(w.metrics[options_.goal]);
        if (!whole) break;
        a[s] = o.metrics[options_.goal];
        b[s] = w.metrics[options_.goal];
        const double mean =
            o.metrics[kAbsMean] * o.metrics[kAbsMean] - w.metrics[kAbsMean] * w.metrics[kAbsMean];
        pairs.mean_part.add(mean);
        pairs.all_part.add(mean + o.metrics[kStd] * o.metrics[kStd] - w.metrics[kStd] * w.metrics[kStd]);
      }
      if (!whole) continue;
      pairs.old_goal.insert(pairs.old_goal.end(), a, a + kPromiseSeeds);
      pairs.new_goal.insert(pairs.new_goal.end(), b, b + kPromiseSeeds);
      advice_.old_goal.push_back(0.5 * (a[0] + a[1]));
      advice_.new_goal.push_back(0.5 * (b[0] + b[1]));
    }
  }

  /// True where more draws would hardly change whether the gain is worth advice.
  bool decided(const Pairs& pairs) const {
    if (int(pairs.old_goal.size()) < kPromiseSeeds * (kFirstDraws - kMayStop) || pairs.stopped_more > 0)
      return false;
    return promise_of(pairs.old_goal, pairs.new_goal, kPromiseSeeds, options_.promised_prints).clear >=
           kDecided;
  }

  void promise() {
    Pairs pairs;
    for (int done = 0; done < promise_draws_ && !(done > 0 && decided(pairs));) {
      const int next = std::min(promise_draws_, done > 0 ? done + kMoreDraws : kFirstDraws);
      print_pairs(done, next, pairs);
      done = next;
    }
    if (pairs.old_goal.size() < 8) throw UsageError(run_.name + ": hardly any simulated print finishes");
    advice_.promise = promise_of(pairs.old_goal, pairs.new_goal, kPromiseSeeds, options_.promised_prints);
    Promise& p = advice_.promise;
    p.mean_error_share = pairs.all_part.sum != 0.0 ? pairs.mean_part.sum / pairs.all_part.sum : 0.0;
    if (pairs.stopped_more > 0)
      advice_.rejected.push_back({text_of(keys_, advice_.new_setting), "some prints do not finish"});
    advice_.gain_shown = pairs.stopped_more <= 0 && p.sure >= kMinSure && p.gain >= kMinGain * p.old_mean &&
                         p.gain_interval.high > 0.0 && advice_.new_setting != advice_.old_setting;
  }

  const FittedLab& lab_;
  const RecordedRun& run_;
  std::span<const TuneKey> keys_;
  const AdviceOptions& options_;
  Experiment base_;
  int free_ = 0, evaluations_ = 1, promise_draws_ = 32, prints_ = 0;
  double expected_ = 1.0, best_ = 0.0;
  std::vector<double> best_goals_;  ///< of the best setting so far, of each draw
  Outcome recorded_;
  std::map<Setting, double> evaluated_;
  Advice advice_;
};

statistics::Interval interval(double mean, double std, double freedom) {
  const double half = statistics::student_t_95(freedom) * std;
  return {mean - half, mean + half};
}

/// Variance components of values [draw * seeds + seed]: between draws and within them.
struct Components {
  double mean = 0.0, between = 0.0, within = 0.0;
};
Components components_of(std::span<const double> v, int seeds) {
  const int draws = int(v.size()) / seeds;
  Mean all;
  double within = 0.0;
  for (int d = 0; d < draws; ++d) {
    Mean one;
    for (int s = 0; s < seeds; ++s) one.add(v[std::size_t(d * seeds + s)]);
    within += one.variance() / draws;
    all.add(one.mean());
  }
  return {all.mean(), std::max(0.0, all.variance() - within / seeds), within};
}

/// 95 % interval of exp(x) - exp(y), x and y of Student's bivariate t about their means. Errors are positive
/// and scale with the laboratory, so that a gain scatters farther upwards than downwards.
/// @param difference_std of x - y
statistics::Interval gain_of_scales(double x, double y, double x_std, double y_std, double difference_std,
                                    double freedom) {
  constexpr int kRadii = 160, kAngles = 64;
  double common = 0.0;
  if (x_std > 0.0 && y_std > 0.0)
    common = (x_std * x_std + y_std * y_std - difference_std * difference_std) / (2.0 * x_std * y_std);
  common = std::clamp(common, -1.0, 1.0);
  const double own = std::sqrt(1.0 - common * common);
  std::vector<double> gain;
  for (int k = 0; k < kRadii; ++k) {
    const double beyond = (k + 0.5) / kRadii;
    const double radius = std::sqrt(freedom * (std::pow(beyond, -2.0 / freedom) - 1.0));
    for (int n = 0; n < kAngles; ++n) {
      const double angle = 2.0 * std::numbers::pi * (n + 0.5) / kAngles;
      const double u = radius * std::cos(angle), v = radius * std::sin(angle);
      gain.push_back(std::exp(x + x_std * u) - std::exp(y + y_std * (common * u + own * v)));
    }
  }
  const auto quantile = [&gain](double share) {
    const auto at = gain.begin() + std::lround(share * double(gain.size() - 1));
    std::ranges::nth_element(gain, at);
    return *at;
  };
  return {quantile(0.025), quantile(0.975)};
}

}  // namespace

std::string unsafe_trait(const PrintTraits& t, const PrintTraits& recorded) {
  if (t.saturated > kTimes * recorded.saturated + kSaturatedMore)
    return fmt::format("saturates: {:.0f} % of the cells get the most that they may, {:.0f} % before",
                       100 * t.saturated, 100 * recorded.saturated);
  if (t.alternation < kAlternates && t.swing > recorded.swing + kSwingMore)
    return fmt::format("oscillates: what a layer gets swings by {:.0f} %, {:.0f} % before", 100 * t.swing,
                       100 * recorded.swing);
  if (t.overspill > kTimes * recorded.overspill + kOverspillMore)
    return fmt::format("deposits outside the part: {:.1f} % of its volume, {:.1f} % before",
                       100 * t.overspill, 100 * recorded.overspill);
  return "";
}

std::size_t goal_index(const Experiment& experiment, const std::string& goal) {
  const auto& metrics = study_lab_of(experiment).metrics;
  std::string names;
  for (std::size_t n = 0; n < metrics.size(); ++n) {
    if (metrics[n].name == goal || metrics[n].name == goal + "_um") return n;
    names += (n ? ", " : "") + metrics[n].name;
  }
  throw UsageError("--goal: '" + goal + "' is none of " + names);
}

Promise promise_of(std::span<const double> old_goal, std::span<const double> new_goal, int seeds,
                   int prints) {
  Promise p;
  p.old_mean = components_of(old_goal, seeds).mean;
  p.new_mean = components_of(new_goal, seeds).mean;
  p.gain = p.old_mean - p.new_mean;
  const auto positive = [](double v) { return v > 0.0; };
  const bool scales = std::ranges::all_of(old_goal, positive) && std::ranges::all_of(new_goal, positive);
  std::vector<double> from(old_goal.begin(), old_goal.end()), to(new_goal.begin(), new_goal.end());
  if (scales)
    for (std::vector<double>* all : {&from, &to})
      for (double& v : *all) v = std::log(v);
  std::vector<double> difference(from.size());
  for (std::size_t n = 0; n < from.size(); ++n) difference[n] = from[n] - to[n];
  const Components o = components_of(from, seeds), w = components_of(to, seeds),
                   g = components_of(difference, seeds);
  const double draws = double(from.size()) / seeds, freedom = draws - 1.0;
  // One laboratory's mean over `prints`, and the error of the simulated mean.
  const auto std = [&](const Components& c) {
    return std::sqrt(c.between * (1.0 + 1.0 / draws) + c.within * (1.0 / prints + 1.0 / (draws * seeds)));
  };
  const double lab_std = std::sqrt(g.between * (1.0 + 1.0 / draws) + g.within / (draws * seeds));
  double centre = g.mean, least = kMinGain * p.old_mean;
  if (scales) {
    // The mean over prints is larger than its logarithm says by half their variance.
    const double old_log = o.mean + 0.5 * o.within, new_log = w.mean + 0.5 * w.within;
    p.gain_interval = gain_of_scales(old_log, new_log, std(o), std(w), std(g), freedom);
    p.new_interval = interval(new_log, std(w), freedom);
    p.new_interval = {std::exp(p.new_interval.low), std::exp(p.new_interval.high)};
    centre = old_log - new_log;
    least = -std::log1p(-kMinGain);
  } else {
    p.gain_interval = interval(p.gain, std(g), freedom);
    p.new_interval = interval(p.new_mean, std(w), freedom);
  }
  p.gain_interval.low = std::min(p.gain_interval.low, p.gain);
  p.gain_interval.high = std::max(p.gain_interval.high, p.gain);
  p.clear = lab_std > 0.0 ? std::abs(centre - least) / lab_std : std::numeric_limits<double>::infinity();
  const auto sure_at = [&](double scatter) {
    if (scatter > 0.0) return statistics::student_t_cdf(centre / scatter, freedom);
    return centre > 0.0 ? 1.0 : centre < 0.0 ? 0.0 : 0.5;
  };
  p.sure = sure_at(lab_std);
  p.prints = prints;
  p.sure_of_prints = sure_at(std(g));
  return p;
}

Advice advise(const FittedLab& lab, const RecordedRun& run, std::span<const TuneKey> keys,
              const AdviceOptions& options) {
  return Adviser(lab, run, keys, options).run();
}

}  // namespace firn::tune
