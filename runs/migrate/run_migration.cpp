#include "runs/migrate/run_migration.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "lcmtypes/channels.h"

namespace firn::runs {
namespace {

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

}  // namespace

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

}  // namespace firn::runs
