// Fills a run's log from its write-ahead files: at the end of a print, at a resume, and by `firn log repair`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "files/record/repair.h"

namespace firn::runs {

/// Adds the missing messages to the log. Nobody may be writing the log.
/// @param log log.lcm of the run; made if the run has no log
/// @param nodes_folder its nodes/: every message of a reliable, logged channel among the outputs of *.wal and
/// *.sent, and the CONFIG_ message of every head, must be in the log
/// @throws record::FileError; the old log is then untouched
record::RepairReport repair_from_write_ahead(const std::filesystem::path& log,
                                             const std::filesystem::path& nodes_folder);

/// Calls `use` with channel and sequence number of every message that the repair would take from the
/// write-ahead files, in the order of the files. @throws record::FileError
void each_sent_message(const std::filesystem::path& nodes_folder,
                       const std::function<void(std::string_view channel, std::int64_t seq)>& use);

/// Returns the (incarnation, seq) of a message with a header; nothing for others.
std::optional<record::MessageKey> message_key(std::string_view channel, std::span<const std::byte> message);

}  // namespace firn::runs
