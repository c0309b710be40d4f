// Writes the report's sections for runs of the ice lab: part as built, error maps per interval, RMS against
// height, speed and frequency along one path [Barnett 2012, Figs. 5-8, 5-9, 6-2, 6-3].
#pragma once

#include <string>
#include <vector>

#include "report/run/report_ice_data.h"

namespace firn::report {

struct NamedIce {
  std::string name;
  const IceData* data;
  int style = 0;  ///< of its lines
};

/// Returns HTML; empty for no run.
std::string ice_sections(const std::vector<NamedIce>& runs);

/// Draws a height field as seen under a light from above the upper left, with contour lines every `step_mm`.
std::string shaded_relief(const HeightMap& height, double step_mm, const std::string& title);

}  // namespace firn::report
