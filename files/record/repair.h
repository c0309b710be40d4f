// repair fills the gaps of an event log from other records of the same messages (the write-ahead files) and
// omits damage: a new log in time order replaces the old one at once. The caller provides the keys of
// messages.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "files/record/damage.h"

namespace firn::record {

/// Identity of a message within its channel, in sending order: (incarnation, seq).
struct MessageKey {
  std::uint64_t high = 0, low = 0;
  auto operator<=>(const MessageKey&) const = default;
};

/// A message that must be in the log. Views stay valid until repair() returns.
struct SourceMessage {
  std::int64_t utime_us = 0;
  std::string_view channel;
  MessageKey key;
  std::span<const std::byte> data;
};

/// Returns the next message that must be in the log, in any order, repeats allowed; nothing at the end.
using MessageSource = std::function<std::optional<SourceMessage>()>;
/// Returns the key of an event of the log; nothing for events that no source names (these are kept
/// unchanged).
using KeyOf =
    std::function<std::optional<MessageKey>(std::string_view channel, std::span<const std::byte> data)>;

struct ChannelGap {
  std::string channel;
  std::uint64_t inserted = 0;
  std::uint64_t replaced = 0;  ///< damaged in the log, whole in a source
  std::int64_t first_utime_us = 0;
  std::int64_t last_utime_us = 0;
};

struct RepairReport {
  bool rewritten = false;        ///< false: nothing was wrong, the log is untouched
  std::uint64_t events = 0;      ///< in the log now
  std::vector<ChannelGap> gaps;  ///< by channel name
  std::uint64_t inserted = 0, replaced = 0;
  std::uint64_t repeated = 0;       ///< repeated events of one key: the first whole one is kept
  std::uint64_t left_out = 0;       ///< damaged events that no source holds; kept_path still has them
  DamageList damage;                ///< of the old log
  std::filesystem::path kept_path;  ///< the old log, kept if it was damaged: "<log>.before-repair-<n>"
};

/// Returns "recording gap, repaired: 12 messages of HEIGHT_PROFILE between 3.200000 s and 3.900000 s", one
/// line per channel.
std::vector<std::string> describe(const RepairReport& report);

/// Repairs `log` and its index; creates both if there is no log. An inserted message is placed by its time,
/// but never before its predecessor on the same channel. Requires disk space for a second log.
/// @throws FileError, also when somebody is writing the log; the old log is then untouched
RepairReport repair(const std::filesystem::path& log, const MessageSource& source, const KeyOf& key_of);

}  // namespace firn::record
