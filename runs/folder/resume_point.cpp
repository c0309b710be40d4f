#include "runs/folder/resume_point.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "runtime/wal_file.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

/// The newest time in the world's own record; every payload there begins with its time.
std::int64_t world_end_us(const fs::path& record_file) {
  std::int64_t last = 0;
  if (!fs::exists(record_file)) return last;
  const record::MappedFile mapped(record_file);
  record::RecordReader reader(mapped.bytes());
  while (const auto record = reader.next()) {
    std::int64_t t_us = 0;
    if (record->damaged || record->payload.size() < sizeof t_us) continue;
    std::memcpy(&t_us, record->payload.data(), sizeof t_us);
    last = std::max(last, t_us);
  }
  return last;
}

}  // namespace

ResumePoint read_resume_point(const fs::path& run_dir, const std::vector<std::string_view>& channels) {
  ResumePoint point;
  std::int64_t last_us = world_end_us(RunPaths(run_dir).world_record_path());
  std::int32_t incarnation = -1;
  for (const fs::path& file : RunPaths(run_dir).wal_files()) {
    const record::MappedFile mapped(file);
    record::RecordReader reader(mapped.bytes());
    while (const auto record = reader.next()) {
      if (record->damaged) continue;
      if (record->kind == std::uint16_t(WalKind::kHead)) {
        incarnation = std::max(incarnation, decode_head(record->payload).incarnation);
      } else if (record->kind == std::uint16_t(WalKind::kEvent)) {
        last_us = std::max(last_us, decode_event(record->payload).event.now.us);
      } else if (record->kind == std::uint16_t(WalKind::kOutputs)) {
        for (const Output& o : decode_output_list(decode_outputs(record->payload).body))
          if (o.kind == OutputKind::kSend &&
              std::find(channels.begin(), channels.end(), o.channel) != channels.end())
            point.newest[std::string(o.channel)].assign(o.bytes.begin(), o.bytes.end());
      }
    }
  }
  if (incarnation < 0)
    throw std::runtime_error(run_dir.string() +
                             ": no node of this run has begun, there is nothing to go on with");
  point.incarnation = incarnation + 1;
  point.offset_us = last_us + 1;
  return point;
}

}  // namespace firn::runs
