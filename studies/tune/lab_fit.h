// fit_lab estimates the laboratory that recorded runs come from: simulated prints of the same experiments
// under the same feedback, with parameters drawn in rounds that close in on the recorded features
// (estimators/lab/synthetic_likelihood.h); the class of laboratory is that which predicts the last third of
// the layers best from the first two.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "estimators/lab/synthetic_likelihood.h"
#include "studies/tune/lab_print.h"

namespace firn::tune {

/// Reports the share of the work that is done, with words about it.
using Progress = std::function<void(double fraction, const std::string& about)>;

struct FitOptions {
  std::uint64_t seed = 1;
  int threads = 1;
  int prints = 180;  ///< of every run, over all rounds and classes, about
  Progress progress = {};
  PrintJournal* journal = nullptr;
};

struct ClassScore {
  std::string_view lab;
  double log_predictive = 0.0;  ///< of the last third's features
};

/// Holds the comparison of the runs with prints simulated in the estimated laboratory.
struct FitCheck {
  double largest = 0.0;  ///< |deviation| of the feature that is missed most, in standard deviations
  double limit = 0.0;    ///< beyond it, the laboratory is of no known class
  double joint = 0.0, joint_limit = 0.0;  ///< mean square deviation of all features, whitened
  /// The features beyond the limit, the worst first; for each the run's deviation.
  struct Missed {
    std::string feature;
    double deviation = 0.0;
    bool constant = false;  ///< the same in every simulated print
  };
  std::vector<Missed> missed;
  bool passed() const { return missed.empty(); }
};

struct FittedLab {
  const LabClass* lab = nullptr;
  lab::Normal posterior;
  std::vector<ClassScore> scores;
  FitCheck check;
  int prints = 0;
  int failed = 0;                ///< prints that did not finish, left out
  lab::Simulations simulations;  ///< of the last round
  std::vector<double> observed;  ///< features of the runs, one after the other

  /// Draw number n of the posterior. @param stream draws of different streams are independent
  LabDraw draw(std::uint64_t seed, std::uint32_t stream, std::uint32_t n) const;
};

/// @throws UsageError: hardly any print of the simulated laboratories finishes
FittedLab fit_lab(std::span<const RecordedRun> runs, const FitOptions& options);

}  // namespace firn::tune
