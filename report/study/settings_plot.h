// settings_plot draws the settings that a design of a study varies beside its result, as parallel coordinates
// [Inselberg 1985]: an upright axis for each setting and one for the primary metric, a line for each scheme.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_page.h"
#include "report/study/study_analysis.h"

namespace firn::report {

/// Draws the settings that are numbers and have at least three values. The axes of positive settings that
/// differ twentyfold are logarithmic. Lines are blue for the best quarter of the schemes by their mean of the
/// primary metric over all parts, grey for the others; a scheme without a mean is left out.
/// @param settings of the schemes, one value for each; values that are no numbers are left out
/// @returns "" with fewer than four schemes or without such a setting
std::string settings_plot(const StudyTable& table, const StudyAnalysis& analysis,
                          const std::vector<DifferingParameter>& settings);

}  // namespace firn::report
