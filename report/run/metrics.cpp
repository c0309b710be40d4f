#include "report/run/metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "core/grid/grid.h"
#include "core/grid/outline.h"

namespace firn::report {
namespace {

// Columns of every value of the outline, of the true surface and of the measured map. Where the map's border
// cuts the surface, the size errors are lower bounds.
std::string outline_names() {
  std::string names;
  for (const char* of : {"true_", "measured_"}) {
    for (const OutlineMetric& m : kOutlineMetrics) names += "," + (of + std::string(m.name));
    names += "," + (of + std::string("size_cut"));
  }
  return names;
}

std::string outline_values(const std::optional<OutlineStats>& o) {
  std::string values;
  for (const OutlineMetric& m : kOutlineMetrics) {
    char text[400];  // of a double of up to 314 characters
    const double v = o ? (*o).*m.value * m.factor : kNotMeasured;
    std::snprintf(text, sizeof text, ",%.3f", v);
    values += std::isfinite(v) ? text : ",";
  }
  return values + (!o ? "," : o->cut ? ",1" : ",0");
}

}  // namespace

std::string metrics_csv(const RunData& run) {
  std::string s =
      "layer,attempt,map_id,target_mean_um,mean_height_um,mean_error_um,rms_um,std_um,min_error_um,max_error_"
      "um,volume_mm3,"
      "drops,drops_total,objective_um,iterations,deposit_s,cure_s,scan_s,decide_s,end_s,"
      "true_mean_error_um,true_rms_um,true_std_um,true_max_abs_error_um,rms_inside_um,rms_rim_um,rows_lost,"
      "cells_guessed";
  s += outline_names() + ",passes\n";
  for (const LayerRow& r : run.layers) {
    char line[8192];  // of twenty doubles, each of up to 314 characters
    std::snprintf(
        line, sizeof line,
        "%d,%d,%lld,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.6f,%lld,%lld,%.6f,%lld,%.3f,%.3f,%.3f,%.3f,%.3f,",
        r.layer, r.attempt, static_cast<long long>(r.map_id), r.target_mean_mm * 1e3, r.mean_height_mm * 1e3,
        r.mean_error_mm * 1e3, r.rms_mm * 1e3, r.std_mm * 1e3, r.min_error_mm * 1e3, r.max_error_mm * 1e3,
        r.volume_mm3, static_cast<long long>(r.drops), static_cast<long long>(r.drops_total),
        r.objective_mm * 1e3, static_cast<long long>(r.iterations), r.deposit_s, r.cure_s, r.scan_s,
        r.decide_s, r.end_s);
    s += line;
    if (r.truth) {
      std::snprintf(line, sizeof line, "%.3f,%.3f,%.3f,%.3f", r.truth->mean_mm * 1e3, r.truth->rms_mm * 1e3,
                    r.truth->std_mm * 1e3, std::max(-r.truth->min_mm, r.truth->max_mm) * 1e3);
      s += line;
    } else {
      s += ",,,";
    }
    std::snprintf(line, sizeof line, ",%.3f,%.3f,%d,%lld", r.rms_inside_mm * 1e3, r.rms_rim_mm * 1e3,
                  r.rows_lost, static_cast<long long>(r.cells_guessed));
    s += line + outline_values(r.true_outline) + outline_values(r.measured_outline) + "," +
         std::to_string(r.passes) + "\n";
  }
  return s;
}

}  // namespace firn::report
