// StudyLab holds the properties of a lab that `firn compare` uses: its metrics, its seed, and a function that
// prints once. A study of another lab needs another StudyLab, and no other change.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "config/study.h"
#include "report/study/study_analysis.h"
#include "runtime/node.h"

namespace firn {

/// Holds one print. Metrics are in the lab's order; NaN where the print left no data to measure.
struct StudyPrint {
  bool finished = false;  ///< ran to its end, within tolerance or not
  std::string outcome, reason;
  std::vector<double> metrics;
  double cpu_s = 0.0;                                   ///< differs from run to run
  std::vector<report::StudyProfilePoint> profile = {};  ///< of labs that have one
  std::optional<bool> within = {};  ///< the true RMS is at most tolerance_of_part_um; none: no target
  std::string document = {};        ///< text of the work's own, UTF-8
};

struct MemoryPrintReport;

/// The metric that takes a solver longer than the print.
inline constexpr std::string_view kEdgeBound = "edge_bound_pct";

struct StudyLab {
  std::vector<report::StudyMetric>
      metrics;  ///< smaller is better in each; the first is primary unless a study says else
  std::vector<std::string> usual;  ///< metrics of a study that names no metrics
  void (*set_seed)(Experiment&, std::uint64_t seed);
  void (*check)(const Experiment&);  ///< throws where this lab cannot print the experiment
  /// Thread-safe; throws only std::bad_alloc. @param edge_bound computes kEdgeBound too, by a solver for
  /// seconds; else it is NaN
  StudyPrint (*print)(const Experiment&, const Blobs& inputs, bool edge_bound);
  report::StudyProfileNames profile = {};
};

/// Lu's ink-jet lab in simulated time; metrics are of the true surface.
const StudyLab& inkjet_study_lab();

/// Barnett's ice lab: the same, and the true RMS of every interval, hours of deposition and of measurement.
const StudyLab& ice_study_lab();

/// The aerosol lab: section, height and width of the true lines, their ends.
const StudyLab& aerosol_study_lab();

/// Returns the RMS error above which a print of a study is out of tolerance [um]; 0: it prints towards no
/// target. A study sets the part for all of its schemes, also for one that is given its number of layers:
/// that is judged here, and not by `firn print`.
double tolerance_of_part_um(const Experiment& experiment);

/// Returns the lab of an experiment.
const StudyLab& study_lab_of(const Experiment& experiment);
/// Returns a print's metrics in the order of its experiment's lab; NaN where nothing was printed. Those of
/// ice are taken from `series` too.
std::vector<double> study_metrics(const Experiment& experiment, const MemoryPrintReport& report);

/// Returns the lab of a study's experiment. @param folder of the study file
/// @throws ConfigError: an experiment that cannot be read
const StudyLab& study_lab_of(const Study& study, const std::filesystem::path& folder);

}  // namespace firn
