// Replays one node from its own write-ahead file and collects the messages that the node sent and received,
// for the checks between nodes.
#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "files/record/spill.h"
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

/// Holds the messages that a node sent on one channel, in the order of sending. Millions in a long run.
class SentList {
 public:
  explicit SentList(record::Spill& blocks) : list_(blocks) {}
  void push_back(const Sent& sent);
  std::size_t size() const { return list_.size(); }
  /// Returns a message that is valid until the next call. @pre n < size()
  const Sent& operator[](std::size_t n) const { return list_[n]; }
  /// Returns the place of the message with this number; nothing if there is none.
  std::optional<std::size_t> position(std::int64_t seq) const;
  /// Returns the place of the first message with a larger number; size() if there is none.
  std::size_t after(std::int64_t seq) const;

 private:
  record::LongList<Sent> list_;
  bool ascending_ = true;
  std::int64_t last_ = 0;
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
  std::unique_ptr<record::Spill> sent_blocks =
      std::make_unique<record::Spill>(record::LongList<Sent>::kBlock_bytes);
  std::unique_ptr<record::Spill> delivered_blocks =
      std::make_unique<record::Spill>(record::LongList<Delivered>::kBlock_bytes);
  std::vector<SentList> sent;  ///< by ChannelIndex
  record::LongList<Delivered> delivered{*delivered_blocks};
  std::vector<Gap> gaps;        ///< reported by check_deliveries, which has the times of sending
  std::uint64_t more_gaps = 0;  ///< behind the first RunVerdict::kKeptPerNode
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
