#include "config/swaths.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "config/device_kinds.h"
#include "core/options/for_people.h"

namespace firn {

std::vector<double> swath_shifts_mm(const Experiment& e) {
  const double middle_mm = 0.5 * (e.grid.x_mm(0) + e.grid.x_mm(e.grid.nx - 1));
  if (has_point_scan(e)) {  // the spot over the middle of each column
    std::vector<double> columns;
    for (int i = 0; i < e.grid.nx; ++i)
      columns.push_back(e.grid.x_mm(i) - middle_mm - e.laser_profiler.offset_x_mm);
    return columns;
  }
  const double width_mm = (e.grid.nx - 1) * e.grid.pitch_x_mm;
  const double line_mm = e.laser_profiler.dx_mm * (e.laser_profiler.points - 1);
  if (e.laser_profiler.dx_mm == 0.0 || line_mm >= width_mm * (1.0 - 1e-9)) return {0.0};
  const double step_mm = line_mm - kSwathOverlap * e.grid.pitch_x_mm;
  const double steps = step_mm > 0.0 ? std::ceil((width_mm - line_mm) / step_mm - 1e-9) : kMaxSwaths;
  if (steps >= kMaxSwaths)
    throw std::invalid_argument("a line of " + for_people(line_mm) + " mm needs more than " +
                                std::to_string(kMaxSwaths) + " swaths of a grid of " + for_people(width_mm) +
                                " mm, which overlap by " + std::to_string(kSwathOverlap) + " cells");
  const int n = int(steps) + 1;
  std::vector<double> shifts;
  for (int k = 0; k < n; ++k) shifts.push_back((width_mm - line_mm) * (double(k) / (n - 1) - 0.5));
  return shifts;
}

}  // namespace firn
