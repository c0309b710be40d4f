// ChannelInfo holds a row of the table of channels, NodeInfo one of the table of nodes: senders and receivers
// (typed), transport, recorder, replay, `firn log` and docs/dataflow.md follow them. A channel that stands
// alone has a constant: channels::kHeightMap, from channels.table.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firn/channels.h"

namespace firn {

struct NodeInfo {
  NodeId id;
  std::string_view name;  ///< process, write-ahead file and CONFIG_/FAULT_/HEARTBEAT_ suffix (upper case)
  double longest_step_s;  ///< wall time that one step may take before safety calls the node dead
  bool driver;            ///< talks to an instrument and honours the lease
};
std::span<const NodeInfo> nodes();
const NodeInfo& info(NodeId id);
/// @returns nullptr for an unknown name.
const NodeInfo* find_node(std::string_view name);

enum class Delivery : std::uint8_t {
  kReliable,  ///< every message, in order, once: gaps are asked for again
  kLatest,    ///< only the newest counts; a stale or repeated one is dropped
};

struct ChannelInfo {
  std::string_view name;
  std::string_view type;
  NodeId publisher;
  Delivery delivery;
  double rate_hz;  ///< typical; 0 = on event
  int queue;       ///< receive queue [messages]; 0 = unlimited
  bool logged;
  std::string_view meaning;
  /// False where only tests, audit and reports may read (SIM_TRUTH), and where no node reads.
  bool nodes_may_read = true;
};
std::span<const ChannelInfo> channel_table();
/// @returns nullptr for an unknown name.
const ChannelInfo* find_channel(std::string_view name);

namespace channels {
// One channel per node: ANSWER_STAGE, STATE_JET, FAULT_SAFETY, CONFIG_LAMP, HEARTBEAT_RECORDER, …
Channel<answer_t> answer(NodeId node);              ///< drivers only
Channel<device_state_t> device_state(NodeId node);  ///< drivers only
Channel<fault_t> fault(NodeId node);
Channel<config_t> config(NodeId node);
Channel<heartbeat_t> heartbeat(NodeId node);
Channel<resend_request_t> resend_request(NodeId node);
Channel<journal_t> journal(NodeId node);  ///< replayed nodes only
}  // namespace channels

}  // namespace firn
