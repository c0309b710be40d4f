// The words of a study's result.
#pragma once

#include <string>
#include <vector>

#include "report/study/study_analysis.h"

namespace firn::replay {

/// One line: the best arm, by how much it betters the next and the baseline and how sure that is; or which
/// arms are not distinguishable.
std::string study_answer(const StudyTable& table, const StudyAnalysis& analysis);
std::vector<std::string> study_notes(const StudyTable& table, const StudyAnalysis& analysis);

}  // namespace firn::replay
