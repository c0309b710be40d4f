// Writes a study's result in words.
#pragma once

#include <string>
#include <vector>

#include "report/study/study_analysis.h"

namespace firn::replay {

/// Returns one line: the best arm, its lead over the next and the baseline and the certainty of that lead; or
/// the arms that are not distinguishable.
std::string study_answer(const StudyTable& table, const StudyAnalysis& analysis);
std::vector<std::string> study_notes(const StudyTable& table, const StudyAnalysis& analysis);

}  // namespace firn::replay
