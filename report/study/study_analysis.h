// StudyAnalysis holds the result of a study: paired comparisons of its arms (schemes) over parts and seeds,
// and the sentence that names the better arm, the difference and its certainty. It knows no lab: metrics are
// columns of numbers, smaller is better in each.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics/comparison.h"

namespace firn::report {

struct StudyMetric {
  std::string name, unit, meaning;  ///< "rms_um", "um", "RMS of the true surface about the target"
  int decimals = 2;
};

/// Holds a value along a print.
struct StudyProfilePoint {
  double x = 0.0, y = 0.0;
};

/// Holds the names of a lab's profiles; all empty if the lab has no profiles.
struct StudyProfileNames {
  std::string title, x_name, y_name;  ///< "True RMS against height", "height_mm", "rms_um"
};

struct StudyRun {
  bool finished = false;  ///< ran to its end, however good it is; else it stopped
  std::string outcome, reason;
  std::vector<double>
      metrics;  ///< one for each metric; also of a print that stopped, where it left a surface
  std::vector<StudyProfilePoint> profile = {};
  std::optional<bool> within = {};  ///< the surface it left is within tolerance; none: the lab has none

  /// Returns whether its metrics count: it finished, or a guard stopped it when the part was within
  /// tolerance.
  bool complete() const { return finished || within.value_or(false); }
  bool failed() const { return within ? !*within : !finished; }
};

struct StudyTable {
  std::string name;
  std::vector<std::string> arms, parts;
  std::vector<std::uint64_t> seeds;
  std::vector<StudyMetric> metrics;  ///< the first is primary
  std::string baseline;              ///< an arm, or ""
  std::string judged = {};           ///< an arm that shall nowhere be behind the best other one, or ""
  double margin = 1.1;               ///< by more than this factor
  std::vector<StudyRun> runs;        ///< [(arm * parts + part) * seeds + seed]
  StudyProfileNames profile = {};
  std::string trial = "seed";           ///< that all arms share: "seed", or "block" of recorded runs
  std::vector<std::string> notes = {};  ///< limits of the data
  const StudyRun& run(std::size_t arm, std::size_t part, std::size_t seed) const {
    return runs[(arm * parts.size() + part) * seeds.size() + seed];
  }
};

inline constexpr int kAllParts = -1;

/// Summarizes an arm by itself, over its complete prints. Over all parts, a seed counts when
/// all its parts are complete.
struct ArmSummary {
  std::size_t arm = 0, metric = 0;
  int part = kAllParts;
  std::size_t seeds = 0;  ///< that count
  double mean = 0.0;
  statistics::Interval interval;
};

/// Compares two arms under common random numbers. The unit is the seed: its pairs on the several parts share
/// one nature, so each seed gives one difference, the mean of those on the parts that both completed. A print
/// without a usable part has no error that could be averaged with others, so it is a second endpoint, as in
/// two-part models of data with excess failures [Lachenbruch, Stat. Methods Med. Res. 11 (2002) 297]: for
/// each seed the number of failed prints of a less that of b, under the same sign-flip test (for one part
/// this is McNemar's exact test). Both tests are the same when the two arms are exchanged.
struct ArmComparison {
  std::size_t a = 0, b = 0, metric = 0;
  int part = kAllParts;
  statistics::PairedComparison values;  ///< a - b; but a_below_b is of all pairs, where a failed print loses
  double holm_p = 1.0;  ///< of the values, in the family: all pairs of arms, same metric and part
  double failures_p = 1.0, failures_holm_p = 1.0;  ///< likewise of the failures
  double lead =
      0.0;  ///< below 0, a is better: the difference, or with failures the share of pairs lost - won
  std::size_t left_out = 0;                ///< seeds without a difference
  std::size_t failed_a = 0, failed_b = 0;  ///< prints that left no part within tolerance, or stopped
  bool any_failed() const { return failed_a + failed_b > 0; }
  bool by_values() const;    ///< the values tell the arms apart, and the failures do not contradict
  bool by_failures() const;  ///< the failures do, and the values do not contradict
  bool told_apart() const { return by_values() || by_failures(); }
  double decisive_p()
      const;  ///< Holm's p of the values, or of the failures if these alone tell the arms apart
  std::size_t better() const;
  /// Returns true if no result of as many seeds could have a smaller p: more seeds would.
  bool at_smallest_p() const;
};

struct StudyAnalysis {
  std::vector<ArmSummary> summaries;       ///< metric-major, then all parts and each part, then arm
  std::vector<ArmComparison> comparisons;  ///< likewise, then pairs; first the primary family
  std::vector<int> stopped;                ///< prints of each arm that stopped before their end
  std::vector<int> out;                    ///< those that ended out of tolerance
  std::vector<std::size_t> ranking;  ///< arms by the primary metric, best first, by how many others each one
                                     ///< leads; empty if no arm has a complete seed
  std::string answer;                ///< one line
  std::vector<std::string> notes;    ///< limits of the answer: failures, few seeds
  const ArmComparison& primary(std::size_t a, std::size_t b) const;  ///< of the pair in either order
};

inline constexpr double kAlpha = 0.05;

/// Returns the table as people read it: metrics in um with a value of 1000 um or more are in mm, "rms_mm" for
/// "rms_um". A table with profiles, which have a unit of their own, stays.
StudyTable in_readable_units(StudyTable table);

/// @pre runs.size() == arms * parts * seeds, and at least one arm, part, seed and metric.
StudyAnalysis analyse(const StudyTable& table);

/// Returns "0.28", without an exponent; "p < 0.001" below that.
std::string p_text(double p);

}  // namespace firn::report
