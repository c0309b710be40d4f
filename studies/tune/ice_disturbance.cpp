#include "studies/tune/ice_disturbance.h"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <set>

#include "config/labs.h"
#include "core/slice/paths/print_paths.h"
#include "files/usage_error.h"
#include "firn/control_surface_t.hpp"
#include "firn/enums.h"
#include "firn/height_map_t.hpp"
#include "firn/path_report_t.hpp"
#include "lcmtypes/convert.h"
#include "report/run/report_ice_data.h"
#include "runs/folder/run_folder.h"
#include "runs/read/run_reader.h"

namespace firn {
namespace {

HeightMap action_of(const control_surface_t& m) {
  HeightMap u(from_message(m.grid), 0.0);
  for (std::size_t c = 0; c < u.size() && c < m.u.size(); ++c) u.cells[c] = double(m.u[c]);
  return u;
}

}  // namespace

std::vector<double> ice_disturbance_of(const std::filesystem::path& folder) {
  const runs::RunFolder run = runs::RunFolder::open(folder);
  const Experiment e = parse_experiment(run.experiment_toml(), run.experiment_path().string());
  if (!prints_paths(e)) throw UsageError(folder.string() + ": not a run of the ice lab");
  const slice::PrintPaths paths = slice::decode_print_paths(blob(run.inputs(), "paths").bytes);
  const runs::RunReader messages(folder);
  std::map<int, height_map_t> maps;          // the last one of each layer that was good enough
  std::map<std::int64_t, HeightMap> action;  // by the map that it answers
  std::set<int> doubted;                     // layers
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    if (m.measured_fraction >= e.process.min_measured_fraction) maps[m.layer] = m;
  });
  messages.each<control_surface_t>(channels::kControlSurface.name,
                                   [&](const control_surface_t& m) { action[m.map_id] = action_of(m); });
  messages.each<path_report_t>(channels::kPathReport.name, [&](const path_report_t& r) {
    if (Outcome(r.outcome) != Outcome::kDone) doubted.insert(r.layer);
  });

  std::vector<double> d;
  HeightMap below, u;
  int layer_below = 0;
  const auto answered = [&](const height_map_t& message) {
    const auto answer = action.find(message.map_id);
    return answer == action.end() ? HeightMap() : answer->second;
  };
  if (const auto table = maps.find(0); table != maps.end()) {  // measured bare: ice.map_table
    below = height_of(table->second);
    u = answered(table->second);
    maps.erase(table);
  }
  for (const auto& [layer, message] : maps) {
    const slice::LayerPaths* top = slice::find_layer(paths, layer);
    if (!top || layer <= layer_below || doubted.lower_bound(layer_below + 1) != doubted.upper_bound(layer))
      break;
    const HeightMap height = height_of(message);
    const HeightMap before =
        below.size() ? resample(below, height.spec, kNotMeasured) : HeightMap(height.spec, 0.0);
    const HeightMap commanded = u.size() ? resample(u, height.spec, 0.0) : HeightMap(height.spec, 0.0);
    const Mask inner = replay::judged_cells(*top, height.spec);
    const double interval_mm = (layer - layer_below) * e.ice.layer_height_mm;
    double sum = 0.0, cells = 0.0;
    for (std::size_t c = 0; c < height.size(); ++c) {
      const double rise_mm = height.cells[c] - before.cells[c];
      if (!inner.cells[c] || !std::isfinite(rise_mm)) continue;
      sum += rise_mm / interval_mm - (1.0 + commanded.cells[c]);
      cells += 1.0;
    }
    if (cells == 0.0) break;
    d.push_back(sum / cells);
    below = height;
    u = answered(message);
    layer_below = layer;
  }
  if (d.size() < 3)
    throw UsageError(fmt::format(
        "the run holds {} measured intervals without a path in doubt; three are needed", d.size()));
  return d;
}

}  // namespace firn
