// RunVerdict holds the findings of replay, per node and for the run. Plain data; replay/print_verdict turns
// it into text or JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/time.h"

namespace firn::replay {

/// Kinds of findings, in the order in which findings of the same moment are reported: causes before their
/// consequences.
enum class FindingKind : std::uint8_t {
  kUnreadable,  ///< a file, record or input that replay needs cannot be used: the node was not replayed
  kForeign,     ///< a file or message of another run or node
  kMissing,     ///< an event, record or delivery that must be there is not
  kOrder,       ///< events are in an impossible order
  kTimer,       ///< a wake-up that was not asked for
  kDelivery,    ///< a node received other bytes than the publisher sent
  kCrash,       ///< the handler throws where the recorded one went on
  kOutput,      ///< the node's output differs from the record
  kLog,         ///< log.lcm differs from the write-ahead files
};
const char* word(FindingKind kind);

struct Finding {
  FindingKind kind = FindingKind::kOutput;
  std::string node;
  std::optional<std::uint64_t> step;
  Time at;              ///< of the event; Time{} if there is no event
  std::string channel;  ///< or "timer 3", "port stage"; empty if no channel is concerned
  std::optional<std::int64_t> seq;
  std::string field;  ///< "drops[17]", "byte 4", "at_us"; empty if no field is concerned
  std::string recorded,
      replayed;      ///< both values of the field; kDelivery: sent, delivered; kLog: recorded, logged
  std::string what;  ///< one sentence
  std::vector<std::string> inputs;  ///< the node's last events up to here, oldest first, one JSON object each
};

/// Holds a place in a file that cannot be trusted.
struct DamagedPlace {
  std::string file;          ///< relative to the run folder
  std::uint64_t offset = 0;  ///< byte
  std::uint64_t bytes = 0;
  std::string reason;
  std::optional<std::uint64_t> step;
};

struct NodeVerdict {
  std::string name;
  std::int32_t incarnations = 0;
  std::uint64_t steps = 0;
  std::uint64_t events_in = 0;  ///< messages delivered
  std::uint64_t messages = 0;   ///< messages sent
  std::uint64_t bytes = 0;      ///< of all outputs that were compared: messages and instrument bytes
  std::uint64_t cut = 0;        ///< last steps of an incarnation whose outputs the kill cut off
  std::uint64_t differing_steps = 0;
  std::uint64_t decisions = 0;            ///< of layers or intervals
  std::uint64_t differing_decisions = 0;  ///< in at least one cell
  std::uint64_t differing_cells = 0;      ///< over all decisions
  std::int64_t recorded_handler_ns = 0;
  std::int64_t handler_ns = 0;  ///< of this replay, where the caller asked for it
  std::int64_t last_us = 0;     ///< node time of the last event
  std::string crash;            ///< "step 12: …": the handler throws at the cut event, as it did in the run
  std::string python;           ///< "control.scheme = python:…": code that was not run, so no replay
};

struct Ignored {
  std::string field, reason;
  std::uint64_t times = 0;
};

struct RunVerdict {
  std::vector<NodeVerdict> nodes;
  std::vector<std::string> provenance;        ///< mismatches, named before any divergence
  std::vector<std::string> changed_settings;  ///< "control.smf.kp: recorded 1, now 1.5"
  std::vector<std::string> notes;             ///< one line each; no difference by themselves
  std::vector<NodeVerdict> not_replayed;      ///< nodes whose Python code was not run
  std::vector<std::string> altered;           ///< differences of the run folder from its seals
  std::vector<DamagedPlace> damage;
  std::vector<Finding> findings;  ///< at most kKeptPerNode a node; the first divergence first
  std::uint64_t findings_total = 0;
  std::vector<Ignored> ignored;
  double tolerance = 0.0;
  double largest_difference = 0.0;  ///< within the tolerance
  std::string largest_difference_field;
  std::uint64_t log_messages = 0;  ///< of log.lcm, compared
  bool log_present = false;
  std::int64_t wall_ns = 0;

  static constexpr std::size_t kKeptPerNode = 20;
  static constexpr std::size_t kKeptWithInputs = 3;

  bool identical() const {
    return findings_total == 0 && damage.empty() && altered.empty() && !nodes.empty();
  }
  /// 0 identical, 1 differs, 2 nothing differs but a file or record is unreadable.
  int exit_status() const;
};

}  // namespace firn::replay
