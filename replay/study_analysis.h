// What a study says: paired comparisons of its arms (schemes) over parts and seeds, and the sentence that answers "which
// is better, by how much, how sure". Knows no lab: metrics are columns of numbers, smaller is better in each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/statistics/comparison.h"

namespace firn::replay {

struct StudyMetric {
  std::string name, unit, meaning;  ///< "rms_um", "um", "RMS of the true surface about the target"
  int decimals = 2;
};

/// A value along a print.
struct StudyProfilePoint {
  double x = 0.0, y = 0.0;
};

/// What a lab's profiles are; all empty where it has none.
struct StudyProfileNames {
  std::string title, x_name, y_name;  ///< "True RMS against height", "height_mm", "rms_um"
};

struct StudyRun {
  bool finished = false;
  std::string outcome, reason;
  std::vector<double> metrics;  ///< one for each metric; also of a print that failed, where it left a surface
  std::vector<StudyProfilePoint> profile = {};
};

struct StudyTable {
  std::string name;
  std::vector<std::string> arms, parts;
  std::vector<std::uint64_t> seeds;
  std::vector<StudyMetric> metrics;  ///< the first is primary
  std::string baseline;              ///< an arm, or ""
  std::vector<StudyRun> runs;        ///< [(arm * parts + part) * seeds + seed]
  StudyProfileNames profile = {};
  const StudyRun& run(std::size_t arm, std::size_t part, std::size_t seed) const {
    return runs[(arm * parts.size() + part) * seeds.size() + seed];
  }
};

inline constexpr int kAllParts = -1;

/// An arm by itself, over the prints that finished. Over all parts, a seed counts when all its parts finished.
struct ArmSummary {
  std::size_t arm = 0, metric = 0;
  int part = kAllParts;
  std::size_t seeds = 0;  ///< that count
  double mean = 0.0;
  statistics::Interval interval;
};

/// Two arms under common random numbers. The unit is the seed: its pairs on the several parts share one nature, so over
/// all parts each seed gives one difference, the mean of those on the parts. Seeds that either arm did not finish are
/// left out, and counted.
struct ArmComparison {
  std::size_t a = 0, b = 0, metric = 0;
  int part = kAllParts;
  statistics::PairedComparison values;  ///< a - b: below 0, a is better
  double holm_p = 1.0;                  ///< within the family: all pairs of arms, same metric, same part
  std::size_t left_out = 0;             ///< seeds
};

struct StudyAnalysis {
  std::vector<ArmSummary> summaries;       ///< metric-major, then all parts and each part, then arm
  std::vector<ArmComparison> comparisons;  ///< likewise, then pairs; first the primary family
  std::vector<int> failed;                 ///< prints of each arm that did not finish
  std::vector<std::size_t> ranking;        ///< arms by the primary metric, best first; arms without a full seed are left out
  std::string answer;                      ///< one line
  std::vector<std::string> notes;          ///< what limits the answer: failures, few seeds
  const ArmComparison& primary(std::size_t a, std::size_t b) const;  ///< of the pair in either order
};

inline constexpr double kAlpha = 0.05;

/// @pre runs.size() == arms * parts * seeds, and at least one arm, part, seed and metric.
StudyAnalysis analyse(const StudyTable& table);

/// "0.28", without an exponent. "p < 0.001" below that.
std::string p_text(double p);

}  // namespace firn::replay
