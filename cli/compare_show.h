// study_text and study_json write the result of a study for the terminal and for programs.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_page.h"
#include "report/study/study_analysis.h"

namespace firn {

/// Table of the schemes, settings that differ, the pairs of the primary metric, and the answer as the last
/// line.
std::string study_text(const report::StudyTable& table, const report::StudyAnalysis& analysis,
                       const std::vector<report::DifferingParameter>& settings);
/// {study, answer, notes, primary, schemes, comparisons, files}; numbers that are not finite are null.
/// @param provenance names and values of build, platform, seeds
std::string study_json(const report::StudyTable& table, const report::StudyAnalysis& analysis,
                       const std::vector<std::pair<std::string, std::string>>& provenance = {});

}  // namespace firn
