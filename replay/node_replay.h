// Replays one node from its own write-ahead file and collects the messages that the node sent and received,
// for the checks between nodes.
#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "replay/message_compare.h"
#include "replay/options.h"
#include "replay/verdict.h"
#include "runs/folder/recorded_steps.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/channel_index.h"

namespace firn::replay {

/// Holds a sent message as its publisher's file records it.
struct Sent {
  std::int64_t seq = 0;
  std::span<const std::byte> bytes;
  std::uint64_t step = 0;
  Time at;
  bool cut = false;      ///< computed by replay for a step with outputs cut off; perhaps never sent
  bool differs = false;  ///< replay computes other bytes: reported once, for the publisher
};

/// Holds a message as it was delivered to a node.
struct Delivered {
  int channel = 0;  ///< ChannelIndex
  std::int64_t seq = 0;
  std::span<const std::byte> bytes;
  std::uint64_t step = 0;
  Time at;
};

/// Holds a gap: deliveries [from, to] of a channel that are not in the node's file.
struct Gap {
  int channel = 0;
  std::int64_t from = 0, to = 0;
  Finding finding;
};

struct NodeOutcome {
  NodeVerdict verdict;
  std::optional<WalHead> head;    ///< of the first incarnation
  bool replayed = false;          ///< the node could be built
  std::vector<Finding> findings;  ///< the first RunVerdict::kKeptPerNode
  std::uint64_t findings_total = 0;
  std::vector<DamagedPlace> damage;
  std::vector<std::string> provenance;
  // Millions in a long run: a vector that grows would hold them three times over for a moment.
  std::vector<std::deque<Sent>> sent;  ///< by ChannelIndex, in the order of sending
  std::deque<Delivered> delivered;
  std::vector<Gap> gaps;  ///< reported by check_deliveries, which has the times of sending
  std::vector<Ignored> ignored;
  double largest_difference = 0.0;
  std::string largest_difference_field;

  std::unique_ptr<runs::WalFile> file;  ///< keeps the views above alive
  std::deque<std::vector<std::byte>> cut_bytes;
  std::deque<std::vector<std::byte>> migrated;  ///< messages of earlier versions as today's types

  void add(Finding finding);
};

/// @param run the run folder; nodes/<name>.wal and inputs/ are read. Never throws because of the content of
/// the files.
/// @param migration of the run: messages of an earlier version are replayed and compared as today's types
NodeOutcome replay_node(const std::filesystem::path& run, const NodeMaker& maker,
                        const runs::ChannelIndex& channels, const runs::RunMigration& migration,
                        const ReplayOptions& options);

}  // namespace firn::replay
