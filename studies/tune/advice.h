// advise computes the setting of some keys that prints best in an estimated laboratory, and the improvement
// that it promises: the setting is searched on some draws of the laboratory and judged on others, so that the
// luck of the search is no part of the promise.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/statistics/bootstrap.h"
#include "studies/tune/lab_fit.h"
#include "studies/tune/tune_keys.h"

namespace firn::tune {

/// Returns the index in study_lab_of(experiment).metrics. @param goal "rms" or "rms_um"
/// @throws UsageError naming the goals
std::size_t goal_index(const Experiment& experiment, const std::string& goal);

struct AdviceOptions {
  std::size_t goal = 0;  ///< goal_index()
  std::uint64_t seed = 1;
  int threads = 1;
  int prints = 250;          ///< simulated prints, about
  int promised_prints = 10;  ///< the promise is about the mean of so many prints
  Progress progress = {};
  PrintJournal* journal = nullptr;
};

/// The promise for the mean over promised_prints prints with each setting on the same disturbances.
struct Promise {
  double old_mean = 0.0, new_mean = 0.0;  ///< of the goal
  statistics::Interval new_interval;      ///< 95 %
  double gain = 0.0;                      ///< old - new
  statistics::Interval gain_interval;     ///< 95 %
  double clear = 0.0;  ///< standard errors between the gain and the least that is worth a change
  double sure =
      0.5;         ///< probability that the new setting is better in this laboratory, over ever more prints
  int prints = 1;  ///< of which the intervals above are means
  double sure_of_prints = 0.5;    ///< probability that the mean over so many is better
  double mean_error_share = 0.0;  ///< of the gain in the mean square error, the part of the mean error
};

/// Returns why a setting with these means over prints is left out, or nothing.
std::string unsafe_trait(const PrintTraits& traits, const PrintTraits& recorded);

struct Rejected {
  std::string setting, reason;
};

/// Predicted goal along one key about the best setting, the others held.
struct Profile {
  std::size_t key = 0;
  std::vector<double> value, mean, std_error;
  double flat_low = 0.0, flat_high = 0.0;  ///< between, the goal is within kFlat of its least value
};
inline constexpr double kFlat = 0.02;

struct Advice {
  Setting old_setting, new_setting;
  bool gain_shown = false;                 ///< false: nothing to gain that these logs could show
  Promise promise;                         ///< of the best setting found, also where it is not advised
  std::vector<double> old_goal, new_goal;  ///< of each draw of the laboratory, mean of its prints
  std::vector<Rejected> rejected;
  std::vector<Profile> profiles;
  int evaluations = 0, prints = 0;
};

/// @param run whose experiment and part are printed
/// @throws UsageError: the recorded setting itself does not print in the estimated laboratory; too many
/// combinations of words and integers
Advice advise(const FittedLab& lab, const RecordedRun& run, std::span<const TuneKey> keys,
              const AdviceOptions& options);

/// Smallest share of the goal that is worth a change.
inline constexpr double kMinGain = 0.02;
/// Smallest certainty with which a change is advised.
inline constexpr double kMinSure = 0.95;

/// Computes the promise of goals with two settings, [draw * seeds + seed]: from their logarithms where all
/// are positive.
/// @pre equal sizes, at least two draws of two seeds
Promise promise_of(std::span<const double> old_goal, std::span<const double> new_goal, int seeds, int prints);

}  // namespace firn::tune
