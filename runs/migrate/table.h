// Migration holds a message type as an earlier version recorded it and the conversion to today's type,
// RetiredChannel a channel whose members have moved, MigrationTable both. With them, runs of every version
// decode and replay.
//
// A member is added, removed or given another meaning in two places: the .lcm file and a row of table.cpp.
// The row of a type that has changed twice leads to the type of the next row of the same name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string_view>

#include "runs/migrate/message_fields.h"

namespace firn::runs {

struct Migration {
  std::string_view was;  ///< the struct as recorded, in the LCM language, with the name that it has today
  /// Sets the members that today's type has and the old one lacks.
  /// @param companion the message of the retired channel that belongs to `old`; null: no such message was
  /// recorded
  void (*fill)(const MessageFields& old, const MessageFields* companion, NewFields& now);
  std::string_view companions = {};  ///< the retired channel whose members moved into this type
};

/// Describes a retired channel: its members moved into another channel's messages.
struct RetiredChannel {
  std::string_view name;
  std::string_view was;                 ///< its struct
  std::string_view into;                ///< the channel that has its members now
  std::array<std::string_view, 4> key;  ///< members that are equal in the two messages that belong together
  std::string_view reader;  ///< the node that received both and waited for the second; empty: no node
};

/// Holds a row of the table with its parsed types.
struct MigrationStep {
  const Migration* row = nullptr;
  const schema::Type* from = nullptr;
  const schema::Type* to = nullptr;  ///< of the next row of the same name, else today's
};

class MigrationTable {
 public:
  /// Returns the table from every recorded version to the types of lcm_type_texts().
  static const MigrationTable& builtin();
  /// The arguments must outlive the table.
  MigrationTable(std::span<const Migration> rows, std::span<const RetiredChannel> retired,
                 const Schema& today);

  /// Returns the step from the type that `message` begins with; nullptr for today's types and unknown ones.
  const MigrationStep* step_from(std::span<const std::byte> message) const;
  /// Returns the type of a message of today or of any earlier version; nullptr if the type is unknown.
  const schema::Type* type_of(std::span<const std::byte> message) const;

  std::span<const RetiredChannel> retired() const { return retired_; }
  /// @returns nullptr for a channel that is not retired
  const RetiredChannel* retired(std::string_view channel) const;
  const std::map<std::int64_t, MigrationStep>& steps() const { return steps_; }

 private:
  const schema::Type* parse(std::string_view was);

  std::span<const RetiredChannel> retired_;
  const Schema& today_;
  std::deque<Schema> schemas_;
  std::map<std::int64_t, MigrationStep> steps_;                // by the old fingerprint
  std::map<std::int64_t, const schema::Type*> retired_types_;  // by fingerprint
};

}  // namespace firn::runs
