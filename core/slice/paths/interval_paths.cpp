#include "core/slice/paths/interval_paths.h"

#include <algorithm>

namespace firn::slice {

void add_measurement(const LayerRegions& regions, const PathOptions& deposit,
                     const IntervalMeasurement& measurement, LayerPaths& out) {
  PathOptions options = deposit;
  options.hook.on = false;
  options.measure.on = false;
  for (ExtrusionOptions* bead : {&options.part, &options.scaffold}) {
    bead->first_offset_mm = measurement.offset_mm > 0.0
                                ? measurement.offset_mm
                                : std::max(bead->first_offset_mm, 0.25 * measurement.spacing_mm);
    bead->boundary_width_mm = measurement.spacing_mm;
    bead->fill_width_mm = measurement.spacing_mm;
    bead->boundaries = 1;
    bead->pattern = FillPattern::kConcentric;
  }
  const LayerPaths measured = plan_layer(regions, options);
  for (std::size_t material = 0; material < regions.by_material.size(); ++material)
    for (std::size_t n = 0; n < measured.info.size(); ++n) {
      PathInfo info = measured.info[n];
      if (info.material != material || measured.lines[n].size() < 3) continue;
      info.kind = PathKind::kMeasurement;
      info.width = 0;
      out.lines.add(measured.lines[n]);
      out.info.push_back(info);
    }
}

PathOptions with_shifted_fill(PathOptions options) {
  ++options.part.boundaries;
  ++options.scaffold.boundaries;
  return options;
}

}  // namespace firn::slice
