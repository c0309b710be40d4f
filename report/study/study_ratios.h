// Computes ratios of the primary metric between schemes: to the baseline on each part and over all parts,
// performance profiles, schemes that no other betters in every metric, and whether a judged scheme is
// nowhere more than a margin behind the best one.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/statistics/group_means.h"
#include "report/study/ratio_summary.h"
#include "report/study/study_analysis.h"

namespace firn::report {

/// A scheme against the baseline on one part: geometric mean of the paired ratios.
struct PartRatio {
  std::size_t arm = 0, part = 0;
  RatioSummary values;
};

/// A scheme against the baseline over all parts, each of which counts alike.
struct OverallRatio {
  std::size_t arm = 0;
  double ratio = 0.0;             ///< geometric mean over the parts
  statistics::Interval interval;  ///< hierarchical bootstrap of parts, then seeds; NaN for one part
  std::size_t left_out = 0;       ///< pairs of which one has no value
};

/// Performance profile [Dolan and More, Mathematical Programming 91 (2002) 201]: the share of part and seed
/// in which a scheme is within a factor of the best scheme there. A print without a value is within none.
struct PerformanceProfile {
  std::size_t arm = 0;
  std::vector<double> share;  ///< of kProfileFactors
};
inline constexpr double kProfileFactors[] = {1.0, 1.05, 1.1, 1.25, 1.5, 2.0, 3.0};

/// Means over parts and seeds; `bettered` by a scheme that is no worse in any of them and better in one.
struct ParetoPoint {
  std::size_t arm = 0;
  std::vector<double> means;  ///< of StudyRatios::pareto_metrics
  std::optional<std::size_t> bettered_by = {};
};

/// The judged scheme on one part against the best other one, which is chosen by its geometric mean on the
/// other half of the seeds, so that neither is favoured by chance.
struct JudgedPart {
  std::size_t part = 0;
  std::size_t best[2] = {0, 0};  ///< chosen on the second half for the first, and the other way round
  RatioSummary values;
  bool holds = false;  ///< the one-sided 95 % bound of the ratio is at most the margin
};

struct StudyRatios {
  std::size_t baseline = 0;
  std::vector<PartRatio> parts;       ///< part by part, arm by arm
  std::vector<OverallRatio> overall;  ///< by ratio, best first
  std::vector<PerformanceProfile> profiles;
  std::vector<std::size_t> pareto_metrics;  ///< of the table
  std::vector<ParetoPoint> pareto;
  std::optional<std::size_t> judged;  ///< StudyTable::judged
  double margin = 1.1;
  std::vector<JudgedPart> judged_parts;
  bool judged_holds() const;  ///< on every part: an intersection-union test, which needs no adjustment
};

/// Returns nothing if the table names no baseline, has one scheme, or values of the primary metric that are
/// not above 0. Schemes are compared in seeds where both have a value.
std::optional<StudyRatios> study_ratios(const StudyTable& table);

std::string ratios_text(const StudyTable& table, const StudyRatios& ratios);     ///< for the terminal
std::string ratios_section(const StudyTable& table, const StudyRatios& ratios);  ///< HTML

}  // namespace firn::report
