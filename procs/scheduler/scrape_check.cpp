#include "procs/scheduler/scrape_check.h"

#include <cmath>
#include <limits>
#include <string>

namespace firn {

Violation scrape(const HeightMap& height, double nozzle_mm, double clearance_mm) {
  const GridSpec& g = height.spec;
  double highest_mm = -std::numeric_limits<double>::infinity();
  int at_i = 0, at_j = 0, unknown = 0;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double h = height.at(i, j);
      unknown += !std::isfinite(h);
      if (!(h > highest_mm)) continue;
      highest_mm = h;
      at_i = i;
      at_j = j;
    }
  static constexpr const char* kKey = "process.nozzle_clearance_mm";
  const std::string wanted = std::string(kKey) + " = " + std::to_string(clearance_mm) + " mm";
  if (unknown > 0)
    return {std::to_string(unknown) + " cells of the map have no height and count as high: " + wanted +
            " under the nozzle cannot be shown"};
  if (nozzle_mm - highest_mm >= clearance_mm) return {};
  return {"the map reaches " + std::to_string(highest_mm) + " mm at cell (" + std::to_string(at_i) + ", " +
              std::to_string(at_j) + "), the nozzle is at " + std::to_string(nozzle_mm) + " mm: " + wanted +
              " is needed",
          {nozzle_mm - highest_mm, clearance_mm, "mm", kKey}};
}

}  // namespace firn
