// outline_metric_of() and outline_value() make a study's metrics of a part's outline.
#pragma once

#include "core/grid/outline.h"
#include "report/study/study_analysis.h"

namespace firn {

/// In a study smaller is better: errors of size lose their sign.
report::StudyMetric outline_metric_of(const OutlineMetric& metric);
/// @returns the value in the metric's unit; NaN where it is not known
double outline_value(const OutlineMetric& metric, const OutlineStats& outline);

}  // namespace firn
