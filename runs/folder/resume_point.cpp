#include "runs/folder/resume_point.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

#include "files/record/record_file.h"
#include "files/run_paths.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/validate.h"
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

/// Collects the operator's orders: those that a node received, and those that a live launcher sent and no
/// node received any more.
class Orders {
 public:
  void take(std::string_view channel, std::span<const std::byte> message) {
    operator_command_t m{};
    if (channel == channels::kOperatorCommand.name && !validate(*find_channel(channel), message) &&
        m.decode(message.data(), 0, int(message.size())) >= 0)
      all_.try_emplace({m.header.incarnation, m.header.seq}, std::move(m));
  }
  void take_sent(const fs::path& file) {
    if (!fs::exists(file)) return;
    const record::MappedFile mapped(file);
    record::RecordReader reader(mapped.bytes());
    while (const auto record = reader.next())
      if (!record->damaged)
        for (const Output& o : decode_output_list(decode_outputs(record->payload).body))
          take(o.channel, o.bytes);
  }
  std::vector<operator_command_t> in_order() {
    std::vector<operator_command_t> orders;
    for (auto& [place, m] : all_) orders.push_back(std::move(m));
    return orders;
  }

 private:
  std::map<std::pair<std::int32_t, std::int64_t>, operator_command_t> all_;  // by incarnation and number
};

}  // namespace

ResumePoint read_resume_point(const fs::path& run_dir, const std::vector<std::string_view>& channels) {
  ResumePoint point;
  std::int64_t last_us = world_end_us(RunPaths(run_dir).world_record_path());
  std::int32_t incarnation = -1;
  Orders orders;
  orders.take_sent(RunPaths(run_dir).sent_path(info(NodeId::kLauncher).name));
  for (const fs::path& file : RunPaths(run_dir).wal_files()) {
    const record::MappedFile mapped(file);
    record::RecordReader reader(mapped.bytes());
    while (const auto record = reader.next()) {
      if (record->damaged) continue;
      if (record->kind == std::uint16_t(WalKind::kHead)) {
        incarnation = std::max(incarnation, decode_head(record->payload).incarnation);
      } else if (record->kind == std::uint16_t(WalKind::kEvent)) {
        const Event event = decode_event(record->payload).event;
        last_us = std::max(last_us, event.now.us);
        if (event.kind == EventKind::kMessage) orders.take(event.channel, event.bytes);
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
  point.orders = orders.in_order();
  return point;
}

}  // namespace firn::runs
