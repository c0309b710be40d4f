// Draws a study as SVG.
#pragma once

#include <string>
#include <vector>

#include "report/study/study_analysis.h"

namespace firn::report {

/// Draws every finished print as a dot, a row for each arm, with mean and 95 % interval. The axis is
/// logarithmic where the arms differ twentyfold.
std::string distribution_plot(const StudyTable& table, const StudyAnalysis& analysis, int part,
                              std::size_t metric);

/// Draws differences of pairs with their 95 % intervals, in per cent of the larger mean, so that all fit one
/// axis.
std::string forest_plot(const StudyTable& table, const std::vector<const ArmComparison*>& pairs);

/// Draws two metrics against each other: the mean of every arm over all parts as a named mark with both 95 %
/// intervals; "" where no arm finished.
std::string trade_off_plot(const StudyTable& table, const StudyAnalysis& analysis, std::size_t x_metric,
                           std::size_t y_metric);

}  // namespace firn::report
