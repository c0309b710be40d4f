// recorded_study() makes the table of a comparison from runs on record, printed and imported ones, by their
// last measured maps.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/study.h"
#include "report/run/report_page.h"
#include "report/study/study_analysis.h"

namespace firn {

struct RecordedStudy {
  report::StudyTable table;                          ///< the n-th runs of all schemes are a block
  std::vector<report::DifferingParameter> settings;  ///< of the first runs of the schemes
  std::vector<std::string> runs;                     ///< a line for each scheme: its runs by name
};

/// Returns a study whose schemes are the runs' own: the name of an imported run, else its control.scheme.
/// @param by "meta.ink": the schemes are the values of this key instead; empty: as above
/// @throws UsageError: a folder that is no run, a run without the key, schemes with different numbers of runs
Study study_of_runs(const std::vector<std::string>& runs, const std::string& by = "");

/// Layers of a comparison of runs on record, both ends among them.
struct LayerWindow {
  int first = 0, last = 0;  ///< 0, 0: the last measured map alone, and all layers of single prints
  bool given() const { return last > 0; }
  bool holds(int layer) const { return !given() || (layer >= first && layer <= last); }
};
/// Parses "FIRST-LAST". @throws UsageError with the limits
LayerWindow parse_window(const std::string& text);

/// Where each scheme has one run, the layers of these prints are the only scatter there is: the note of each
/// pair has the mean difference over layers with an interval that knows their correlation
/// (core/statistics/correlated_series.h), and says that it is of one print each.
/// @param study with runs in every scheme; `folder` = of the study file
/// @param window its metrics are means over these layers of each run, and not those of the last map
/// @throws UsageError naming the run: no run folder, a finished print without a measured layer, a run given
/// twice; a metric that recorded runs have not. Damage is a note of the table.
RecordedStudy recorded_study(const Study& study, const std::filesystem::path& folder,
                             const LayerWindow& window = {});

}  // namespace firn
