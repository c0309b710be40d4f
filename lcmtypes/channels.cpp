#include "lcmtypes/channels.h"

#include <deque>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "lcmtypes/channel_rows.h"

namespace firn {
namespace {

bool publishes(ChannelFamily::Publisher publisher, const NodeInfo& node) {
  switch (publisher) {
    case ChannelFamily::kDrivers:
      return node.driver;
    case ChannelFamily::kReplayed:
      return int(node.id) < kReplayedNodeCount;
    case ChannelFamily::kAny:
      break;
  }
  return true;
}

std::string channel_name(std::string_view prefix, std::string_view node) {
  std::string name(prefix);
  for (char c : node) name += c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
  return name;
}

struct Table {
  std::deque<std::string> names;  // stable addresses for the string_views below
  std::vector<ChannelInfo> rows;
  std::unordered_map<std::string_view, const ChannelInfo*> row_of;

  Table() {
    rows.assign(shared_channels().begin(), shared_channels().end());
    for (const ChannelFamily& f : channel_families())
      for (const NodeInfo& n : nodes())
        if (publishes(f.publisher, n)) {
          names.push_back(channel_name(f.prefix, n.name));
          rows.push_back({names.back(), f.type, n.id, f.delivery, f.rate_hz, f.queue, f.logged, f.meaning,
                          f.nodes_may_read});
        }
    for (const ChannelInfo& c : rows) row_of.emplace(c.name, &c);
  }
};

const Table& table() {
  static const Table t;
  return t;
}

template <class M>
Channel<M> member(std::string_view prefix, NodeId node) {
  const std::string name = channel_name(prefix, info(node).name);
  const ChannelInfo* row = find_channel(name);
  if (!row) throw std::logic_error("no channel " + name);
  return {row->name};
}

}  // namespace

const NodeInfo& info(NodeId id) { return nodes()[std::size_t(id)]; }

const NodeInfo* find_node(std::string_view name) {
  for (const NodeInfo& n : nodes())
    if (n.name == name) return &n;
  return nullptr;
}

std::span<const ChannelInfo> channel_table() { return table().rows; }

const ChannelInfo* find_channel(std::string_view name) {
  const auto found = table().row_of.find(name);
  return found == table().row_of.end() ? nullptr : found->second;
}

namespace channels {
Channel<answer_t> answer(NodeId n) { return member<answer_t>("ANSWER_", n); }
Channel<device_state_t> device_state(NodeId n) { return member<device_state_t>("STATE_", n); }
Channel<fault_t> fault(NodeId n) { return member<fault_t>("FAULT_", n); }
Channel<config_t> config(NodeId n) { return member<config_t>("CONFIG_", n); }
Channel<heartbeat_t> heartbeat(NodeId n) { return member<heartbeat_t>("HEARTBEAT_", n); }
Channel<resend_request_t> resend_request(NodeId n) { return member<resend_request_t>("RESEND_", n); }
Channel<journal_t> journal(NodeId n) { return member<journal_t>("JOURNAL_", n); }
}  // namespace channels

}  // namespace firn
