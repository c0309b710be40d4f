// Writes one self-contained page for a study: answer, tables, plots, settings that differ, failures,
// provenance.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "report/run/report_page.h"
#include "report/study/study_analysis.h"

namespace firn::report {

struct StudyPage {
  const StudyTable& table;
  const StudyAnalysis& analysis;
  std::vector<DifferingParameter> arm_settings;   ///< that differ between the arms, a value for each
  std::vector<DifferingParameter> part_settings;  ///< that differ between the parts
  std::vector<std::pair<std::string, std::string>> provenance;
  std::string nature = {};  ///< that a seed fixes for all arms
};

std::string study_page(const StudyPage& page);

/// Returns a line for each print: arm, part, seed, outcome, metrics, reason.
std::string study_csv(const StudyTable& table);

}  // namespace firn::report
