#include "runs/read/truth.h"

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include "files/record/event_log.h"
#include "files/run_paths.h"
#include "firn/layer_metrics_t.hpp"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/whole_log.h"

namespace firn::runs {

void each_truth(const std::filesystem::path& run, const std::function<void(std::int32_t, HeightMap)>& use) {
  const std::filesystem::path path = RunPaths(run).log_path();
  if (!std::filesystem::exists(path)) return;
  layer_metrics_t metrics{};
  sim_truth_t m{};
  const auto take = [&](std::string_view channel, std::span<const std::byte> bytes, bool damaged) {
    if (channel == channels::kLayerMetrics.name) decode_recorded(bytes, metrics);
    if (channel != channels::kSimTruth.name || damaged) return;
    if (m.decode(bytes.data(), 0, int(bytes.size())) != int(bytes.size())) return;
    HeightMap surface(from_message(m.grid));
    if (surface.size() != m.height_mm.size()) return;
    std::ranges::copy(m.height_mm, surface.cells.begin());
    use(metrics.layer, std::move(surface));
  };
  const std::string metrics_channel(channels::kLayerMetrics.name), truth(channels::kSimTruth.name);
  if (const auto whole = read_whole_log(run, {metrics_channel, truth})) {
    for (const LoggedMessage& message : whole->messages) {
      take(message.channel->name, message.bytes, false);
      whole->file.forget_before(std::uint64_t(message.bytes.data() - whole->file.bytes().data()));
    }
    return;
  }
  const record::EventLogFile log(path);
  record::EventLogReader reader = log.reader();
  while (const auto event = reader.next()) {
    take(event->channel, event->data, event->damaged);
    log.forget_before(event->offset);
  }
}

}  // namespace firn::runs
