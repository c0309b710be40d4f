// Replays a recorded run: every node from its own write-ahead file, then the checks between the files.
//
//   1. each node alone (node_replay.h): its file is whole and in order, wake-ups were asked for, deliveries
//      have no gaps, every output byte is as recorded;
//   2. between nodes: every message delivered to a node is the message that its publisher sent;
//   3. log.lcm: every message in it is the publisher's, and every reliable message is in it.
#pragma once

#include <filesystem>

#include "replay/options.h"
#include "replay/verdict.h"

namespace firn::replay {

/// Returns the verdict of the run, which reports every fault inside the run's files.
/// @throws std::invalid_argument for a folder that is no run, or an `only_node` that is not in options.makers
RunVerdict replay_run(const std::filesystem::path& run, const ReplayOptions& options);

}  // namespace firn::replay
