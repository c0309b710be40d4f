// RunMigration computes the messages of a recorded run as today's types, NodeMigration the recorded events
// and outputs of one node. A run of this version passes through as it is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "replay/migrations/table.h"
#include "runtime/event.h"

namespace firn::replay {

class RunMigration {
 public:
  using Key = std::pair<std::string_view, std::array<std::int64_t, 4>>;  // retired channel, its key members

  /// Without companions: every message for itself.
  explicit RunMigration(const MigrationTable& table = MigrationTable::builtin()) : table_(table) {}
  /// Reads the messages of retired channels from all write-ahead files of the run, if it has some. Unreadable
  /// files are left to those who replay them.
  explicit RunMigration(const std::filesystem::path& run,
                        const MigrationTable& table = MigrationTable::builtin());

  /// Keeps a message of a retired channel, for the one that has its members now.
  void keep_companion(const RetiredChannel& channel, std::span<const std::byte> message);

  /// The message as today's type: `message` itself when it is, or cannot be read; else the bytes are put into
  /// `into`.
  std::span<const std::byte> today(std::span<const std::byte> message, std::vector<std::byte>& into) const;

  bool has_companion(const Key& key) const { return companions_.contains(key); }
  const MigrationTable& table() const { return table_; }

 private:
  const MigrationTable& table_;
  std::map<Key, std::vector<std::byte>> companions_;
};

/// Events and outputs of one write-ahead file, in its order. Views last as long as `kept` and the file.
class NodeMigration {
 public:
  /// @param kept holds the bytes of messages that have changed
  NodeMigration(const RunMigration& run, std::string_view node, std::deque<std::vector<std::byte>>& kept)
      : run_(run), node_(node), kept_(kept) {}

  /// The channel of an event that today's node is not given: a message of a retired channel, or one that was
  /// waited with for it and comes with it instead.
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

}  // namespace firn::replay
