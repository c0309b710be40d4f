#include "report/run/truth.h"

#include <algorithm>

#include "files/record/event_log.h"
#include "firn/layer_metrics_t.hpp"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "replay/run_migration.h"

namespace firn::replay {

void each_truth(const std::filesystem::path& run, const std::function<void(std::int32_t, HeightMap)>& use) {
  if (!std::filesystem::exists(run / "log.lcm")) return;
  const logfile::EventLogFile log(run / "log.lcm");
  logfile::EventLogReader reader = log.reader();
  layer_metrics_t metrics{};
  sim_truth_t m;
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

}  // namespace firn::replay
