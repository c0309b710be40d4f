// Compares log.lcm with the write-ahead files.
#pragma once

#include <filesystem>

#include "replay/cross_check.h"

namespace firn::replay {

/// Checks the log. Every message of log.lcm that a replayed node sent must be the publisher's bytes. Every
/// reliable message that was sent must be in the log ("recording gap" otherwise: `firn log repair` fills it).
/// Findings and counts go to `verdict`; a run without a log is no finding. Messages of earlier versions are
/// compared as today's types.
/// @throws record::FileError
void check_log(const std::filesystem::path& run, const SentIndex& sent, const runs::ChannelIndex& channels,
               const runs::RunMigration& migration, MessageComparer& comparer, RunVerdict& verdict);

}  // namespace firn::replay
