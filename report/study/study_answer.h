// Writes a study's result in words.
#pragma once

#include <string>
#include <vector>

#include "report/study/study_analysis.h"

namespace firn::report {

/// Returns one line: the best arm, its lead over the next and the baseline and the certainty of that lead; or
/// the arms that are not distinguishable.
std::string study_answer(const StudyTable& table, const StudyAnalysis& analysis);
/// Returns "3 of 16 prints stopped, 2 of 16 OUT OF TOLERANCE"; empty: none of the arm's.
std::string failures_text(const StudyTable& table, const StudyAnalysis& analysis, std::size_t arm);
/// Returns the note that so few seeds cannot tell so many schemes apart; empty: they can.
std::string few_seeds_note(std::size_t arms, std::size_t seeds, const std::string& trial);
std::vector<std::string> study_notes(const StudyTable& table, const StudyAnalysis& analysis);

}  // namespace firn::report
