// read_whole_log() finds the messages of some channels in log.lcm, which holds all messages of a run that is
// over in a tenth of the bytes, where the log can stand for the write-ahead files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "files/record/file.h"
#include "lcmtypes/channels.h"
#include "runs/read/channel_index.h"

namespace firn::runs {

struct LoggedMessage {
  const ChannelInfo* channel = nullptr;
  Stamp stamp;
  std::span<const std::byte> bytes;  ///< in WholeLog::file
};

struct WholeLog {
  record::MappedFile file;
  std::vector<LoggedMessage> messages;  ///< in the order of the log
  std::string config;                   ///< that the nodes began with; empty: the log has none
  int incarnations = 0;                 ///< of which the log has a message
};

/// Memory: 64 bytes for each message of the channels; the log's pages are given back.
/// @param channels wanted ones, all in the channel table
/// @returns nothing where the write-ahead files must be read: the log or its index is missing, a block of the
/// index or a wanted message is damaged, the last incarnation has no end, the numbers of a reliable channel
/// have a gap, or a channel is not logged
std::optional<WholeLog> read_whole_log(const std::filesystem::path& run,
                                       const std::set<std::string, std::less<>>& channels);

}  // namespace firn::runs
