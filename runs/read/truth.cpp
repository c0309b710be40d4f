#include "runs/read/truth.h"

#include <algorithm>

#include "files/record/event_log.h"
#include "files/run_paths.h"
#include "firn/layer_metrics_t.hpp"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "runs/migrate/run_migration.h"

namespace firn::runs {

void each_truth(const std::filesystem::path& run, const std::function<void(std::int32_t, HeightMap)>& use) {
  const std::filesystem::path path = RunPaths(run).log_path();
  if (!std::filesystem::exists(path)) return;
  const record::EventLogFile log(path);
  record::EventLogReader reader = log.reader();
  layer_metrics_t metrics{};
  sim_truth_t m{};
  while (const auto event = reader.next()) {
    if (event->channel == channels::kLayerMetrics.name) decode_recorded(event->data, metrics);
    if (event->channel != channels::kSimTruth.name || event->damaged) continue;
    if (m.decode(event->data.data(), 0, int(event->data.size())) != int(event->data.size())) continue;
    HeightMap surface(from_message(m.grid));
    if (surface.size() != m.height_mm.size()) continue;
    std::ranges::copy(m.height_mm, surface.cells.begin());
    use(metrics.layer, std::move(surface));
  }
}

}  // namespace firn::runs
