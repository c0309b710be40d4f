// The words of a run's end, which terminal, firn runs, firn attach, page and report share.
#pragma once

#include <string>

#include "config/labs.h"
#include "runs/folder/documents.h"

namespace firn::runs {

/// Returns "within tolerance: RMS 3.2 um of the last map, at most 7.6 um", "OUT OF TOLERANCE: ...", "NOT
/// JUDGED: ...", or, of a print towards no target, "no target". Empty: the print can go on.
std::string verdict_words(const RunResult& result, const LabWords& lab);

/// Returns "finished: the last layer is printed": the outcome and why.
std::string end_words(const RunResult& result);

/// Returns "12.3 mm^3 in 4567 droplets; stage 0.21 h, lamp 0.012 h"; empty: nothing was used.
std::string use_words(const PrintUse& use, const LabWords& lab);

/// Returns "cylinder, 10 x 10 x 0.4 mm".
std::string part_words(const PrintedPart& part);

/// Returns the lines of the measured surface: part, error, overspill, audit; those that are known.
std::string result_lines(const RunResult& result, const LabWords& lab);

}  // namespace firn::runs
