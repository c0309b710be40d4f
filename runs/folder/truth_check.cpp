#include "runs/folder/truth_check.h"

#include <algorithm>

#include "files/record/event_log.h"
#include "files/run_paths.h"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "plant/record/record.h"

namespace firn::runs {

TruthCheck check_truth(const std::filesystem::path& run) {
  TruthCheck check;
  const RunPaths paths(run);
  if (!std::filesystem::exists(paths.log_path())) return check;
  std::vector<plant::TruthRecord> told;
  if (std::filesystem::exists(paths.world_record_path()))
    told = plant::read_history(paths.world_record_path()).truths;
  const record::EventLogFile log(paths.log_path());
  record::EventLogReader reader = log.reader();
  std::size_t next = 0;
  std::int64_t uncompared = 0;
  while (const auto event = reader.next()) {
    if (event->channel != channels::kSimTruth.name) continue;
    if (told.empty()) {
      ++uncompared;
      continue;
    }
    const std::string place = "log.lcm, byte " + std::to_string(event->offset) + ": SIM_TRUTH";
    sim_truth_t m{};
    if (m.decode(event->data.data(), 0, int(event->data.size())) != int(event->data.size())) {
      check.differs.push_back(place + " cannot be read");
      continue;
    }
    const auto digest =
        plant::truth_digest(m.layer, m.droplets_fired, m.volume_mm3, from_message(m.grid), m.height_mm);
    const auto found = std::find_if(told.begin() + std::ptrdiff_t(next), told.end(),
                                    [&](const plant::TruthRecord& t) { return t.sha256 == digest; });
    if (found == told.end()) {
      check.differs.push_back(place + " " + std::to_string(m.header.seq) + " is not what the world told");
      continue;
    }
    next = std::size_t(found - told.begin()) + 1;
    ++check.compared;
  }
  if (uncompared)
    check.notes.push_back(
        std::to_string(uncompared) +
        " SIM_TRUTH in log.lcm cannot be compared: world.rec is missing or holds no digest");
  return check;
}

}  // namespace firn::runs
