#include "replay/run_migration.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>

#include "lcmtypes/channels.h"
#include "replay/wal_file.h"

namespace firn::replay {
namespace {

namespace fs = std::filesystem;

RunMigration::Key key_of(const RetiredChannel& channel, const MessageFields& message) {
  RunMigration::Key key{channel.name, {}};
  for (std::size_t n = 0; n < channel.key.size(); ++n)
    if (!channel.key[n].empty()) key.second[n] = message.integer(channel.key[n]);
  return key;
}

// Key of a message of any recorded type. @returns nothing for a damaged one
std::optional<RunMigration::Key> key_of(const MigrationTable& table, const RetiredChannel& channel,
                                        std::span<const std::byte> message) {
  const schema::Type* type = table.type_of(message);
  if (!type) return std::nullopt;
  try {
    return key_of(channel, MessageFields(*type, message));
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

std::vector<std::unique_ptr<WalFile>> files_of(const fs::path& run) {
  std::vector<std::unique_ptr<WalFile>> files;
  for (const NodeInfo& node : nodes()) {
    const fs::path path = run / "nodes" / (std::string(node.name) + ".wal");
    try {
      if (fs::exists(path)) files.push_back(std::make_unique<WalFile>(path));
    } catch (const logfile::FileError&) {
    }
  }
  return files;
}

// "struct NAME" of a recorded .lcm text.
std::string struct_of(std::string_view was) { return std::string(was.substr(0, was.find(" {"))); }

bool knows_retired_channel(const MigrationTable& table, const WalHead& head) {
  return std::ranges::any_of(table.retired(), [&](const RetiredChannel& r) {
    return head.type_texts.find(struct_of(r.was)) != std::string::npos;
  });
}

void keep_companions(WalFile& file, RunMigration& to) {
  const auto keep = [&](std::string_view channel, std::span<const std::byte> bytes) {
    if (const RetiredChannel* retired = to.table().retired(channel)) to.keep_companion(*retired, bytes);
  };
  std::vector<Output> outputs;
  for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
    if (item == WalFile::Item::kHead && !knows_retired_channel(to.table(), file.head())) return;
    if (item != WalFile::Item::kStep && item != WalFile::Item::kStray) continue;
    const RecordedStep& step = file.step();
    if (item == WalFile::Item::kStep && step.event.kind == EventKind::kMessage)
      keep(step.event.channel, step.event.bytes);
    if (!step.has_outputs) continue;
    try {
      decode_output_list(step.outputs, outputs);
    } catch (const std::runtime_error&) {
      continue;
    }
    for (const Output& o : outputs)
      if (o.kind == OutputKind::kSend) keep(o.channel, o.bytes);
  }
}

}  // namespace

RunMigration::RunMigration(const fs::path& run, const MigrationTable& table) : table_(table) {
  for (const auto& file : files_of(run)) keep_companions(*file, *this);
}

void RunMigration::keep_companion(const RetiredChannel& channel, std::span<const std::byte> message) {
  if (const auto key = key_of(table_, channel, message))
    companions_.try_emplace(*key, std::vector<std::byte>(message.begin(), message.end()));
}

std::span<const std::byte> RunMigration::today(std::span<const std::byte> message,
                                               std::vector<std::byte>& into) const {
  std::span<const std::byte> now = message;
  while (const MigrationStep* step = table_.step_from(now)) {
    try {
      const MessageFields old(*step->from, now);
      std::optional<MessageFields> companion;
      if (const RetiredChannel* channel = table_.retired(step->row->companions))
        if (const auto it = companions_.find(key_of(*channel, old)); it != companions_.end())
          companion.emplace(*table_.type_of(it->second), it->second);
      NewFields fields(*step->to);
      step->row->fill(old, companion ? &*companion : nullptr, fields);
      std::vector<std::byte> bytes = fields.encode(old);
      into = std::move(bytes);
    } catch (const std::invalid_argument&) {
      return message;
    }
    now = into;
  }
  return now;
}

std::span<const std::byte> NodeMigration::today(std::span<const std::byte> message) {
  std::vector<std::byte> bytes;
  const auto now = run_.today(message, bytes);
  return now.data() == message.data() ? message
                                      : std::span<const std::byte>(kept_.emplace_back(std::move(bytes)));
}

// The message may have come before its companion, or it comes later.
Event NodeMigration::with_companion(const Event& recorded, const RetiredChannel& channel) {
  Event e = recorded;
  e.channel = kNotGiven;
  const auto key = key_of(run_.table(), channel, recorded.bytes);
  if (!key) return e;
  given_.insert(*key);
  const auto it = waiting_.find(*key);
  if (it == waiting_.end()) return e;
  e.channel = channel.into;
  e.bytes = today(it->second);
  waiting_.erase(it);
  return e;
}

Event NodeMigration::wait_for_companion(const Event& recorded, const RetiredChannel& channel) {
  Event e = recorded;
  const auto key = key_of(run_.table(), channel, recorded.bytes);
  if (key && run_.has_companion(*key) && !given_.contains(*key)) {
    waiting_.insert_or_assign(*key, recorded.bytes);
    e.channel = kNotGiven;
  } else {
    e.bytes = today(recorded.bytes);
  }
  return e;
}

Event NodeMigration::event(const Event& recorded) {
  if (recorded.kind != EventKind::kMessage) return recorded;
  if (const RetiredChannel* channel = run_.table().retired(recorded.channel))
    return with_companion(recorded, *channel);
  const MigrationStep* step = run_.table().step_from(recorded.bytes);
  if (!step) return recorded;
  if (const RetiredChannel* channel = run_.table().retired(step->row->companions);
      channel && channel->reader == node_ && channel->into == recorded.channel)
    return wait_for_companion(recorded, *channel);
  Event e = recorded;
  e.bytes = today(recorded.bytes);
  return e;
}

void NodeMigration::outputs(std::vector<Output>& recorded) {
  std::erase_if(recorded, [&](const Output& o) {
    return o.kind == OutputKind::kSend && run_.table().retired(o.channel);
  });
  for (Output& o : recorded)
    if (o.kind == OutputKind::kSend) o.bytes = today(o.bytes);
}

}  // namespace firn::replay
