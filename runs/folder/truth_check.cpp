#include "runs/folder/truth_check.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "files/record/event_log.h"
#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "firn/sim_truth_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "plant/record/record.h"

namespace firn::runs {
namespace {

// Of a long print the droplets would take most of the memory.
std::vector<plant::TruthRecord> truths_of(const std::filesystem::path& world) {
  const record::MappedFile file(world);
  record::RecordReader reader(file.bytes());
  plant::WorldHistory history;
  while (const auto record = reader.next()) {
    const auto kind = plant::RecordKind(record->kind);
    if (!record->damaged && kind == plant::RecordKind::kTruth) plant::decode(kind, record->payload, history);
    file.forget_before(record->offset);
  }
  return std::move(history.truths);
}

}  // namespace

TruthCheck check_truth(const std::filesystem::path& run) {
  TruthCheck check;
  const RunPaths paths(run);
  if (!std::filesystem::exists(paths.log_path())) return check;
  std::vector<plant::TruthRecord> told;
  if (std::filesystem::exists(paths.world_record_path())) told = truths_of(paths.world_record_path());
  const record::EventLogFile log(paths.log_path());
  record::EventLogReader reader = log.reader();
  std::size_t next = 0;
  std::int64_t uncompared = 0;
  while (const auto event = reader.next()) {
    log.forget_before(event->offset);
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
