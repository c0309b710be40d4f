// RunMigration computes the messages of a recorded run as today's types, NodeMigration the recorded events
// and outputs of one node. A run of this version is not changed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "runs/migrate/table.h"
#include "runtime/event.h"

namespace firn::runs {

class RunMigration {
 public:
  using Key = std::pair<std::string_view, std::array<std::int64_t, 4>>;  // retired channel, its key members

  /// Holds no companions: each message is converted by itself (runs/read/companions.h).
  explicit RunMigration(const MigrationTable& table = MigrationTable::builtin()) : table_(table) {}

  /// Keeps a message of a retired channel, for the message that has its members now.
  void keep_companion(const RetiredChannel& channel, std::span<const std::byte> message);

  /// Returns the message as today's type: `message` itself if it is of today's type or unreadable, else the
  /// bytes written to `into`.
  std::span<const std::byte> today(std::span<const std::byte> message, std::vector<std::byte>& into) const;

  bool has_companion(const Key& key) const { return companions_.contains(key); }
  const MigrationTable& table() const { return table_; }

 private:
  const MigrationTable& table_;
  std::map<Key, std::vector<std::byte>> companions_;
};

/// Decodes one recorded message, of any version, as today's type. @returns false for an unreadable one
template <class Message>
bool decode_recorded(std::span<const std::byte> recorded, Message& message) {
  static const RunMigration migration;
  std::vector<std::byte> kept;
  const std::span<const std::byte> bytes = migration.today(recorded, kept);
  return message.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size());
}

/// Converts events and outputs of one write-ahead file, in its order. Views last as long as `kept` and the
/// file.
class NodeMigration {
 public:
  /// @param kept holds the bytes of messages that have changed
  NodeMigration(const RunMigration& run, std::string_view node, std::deque<std::vector<std::byte>>& kept)
      : run_(run), node_(node), kept_(kept) {}

  /// The channel of an event that is not delivered to today's node: a message of a retired channel, or a
  /// message that waited for its companion and is delivered with it.
  static constexpr std::string_view kNotGiven = "(not given)";

  Event event(const Event& recorded);
  /// Leaves out messages of retired channels.
  void outputs(std::vector<Output>& recorded);

 private:
  std::span<const std::byte> today(std::span<const std::byte> message);
  Event with_companion(const Event& recorded, const RetiredChannel& channel);
  Event wait_for_companion(const Event& recorded, const RetiredChannel& channel);

  const RunMigration& run_;
  std::string_view node_;
  std::deque<std::vector<std::byte>>& kept_;
  std::set<RunMigration::Key> given_;                                // companions
  std::map<RunMigration::Key, std::span<const std::byte>> waiting_;  // for their companions
};

}  // namespace firn::runs
