// Replays a recorded run: every node from its own write-ahead file, then the checks between the files.
//
//   1. each node alone: its file whole and in order, wake-ups asked for, deliveries without gaps, every
//   output byte
//      as recorded (node_replay.h);
//   2. between nodes: what a node was given is what the publisher sent;
//   3. log.lcm: every message in it is the publisher's, and every reliable message is in it.
#pragma once

#include <filesystem>

#include "replay/options.h"
#include "replay/verdict.h"

namespace firn::replay {

/// @throws std::invalid_argument for a folder that is no run, or an `only_node` that is not in
/// options.makers. What is wrong inside the run's files stands in the verdict.
RunVerdict replay_run(const std::filesystem::path& run, const ReplayOptions& options);

}  // namespace firn::replay
