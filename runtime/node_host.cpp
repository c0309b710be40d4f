#include "runtime/node_host.h"

#include <new>

#include "firn/enums.h"
#include "lcmtypes/validate.h"

namespace firn {

NodeHost::NodeHost(NodeId id, std::unique_ptr<Node> node, std::int64_t run_id, WalSink* sink)
    : id_(id), name_(info(id).name), node_(std::move(node)), outbox_(id, run_id), sink_(sink) {
  for (const Node::Route& r : node_->routes()) {
    const ChannelInfo* row = find_channel(r.channel);
    if (!row || !row->nodes_may_read)
      throw std::logic_error(name_ + " must not read " + std::string(r.channel));
    Subscription& s = routes_[row->name];
    s.channel = row;
    s.routes.push_back(&r);
  }
  by_row_.resize(channel_table().size());
  for (const auto& [_, s] : routes_) by_row_[std::size_t(s.channel - channel_table().data())] = &s;
}

const NodeHost::Subscription* NodeHost::subscription(std::string_view channel) const {
  const ChannelInfo* row = find_channel(channel);
  return row ? by_row_[std::size_t(row - channel_table().data())] : nullptr;
}

std::vector<std::string_view> NodeHost::channels() const {
  std::vector<std::string_view> names;
  for (const auto& [name, _] : routes_) names.push_back(name);
  return names;
}

const Outbox& NodeHost::step(const Event& event) {
  if (sink_) {
    scratch_.clear();
    encode_event(steps_, event, scratch_);
    sink_->append(WalKind::kEvent, scratch_);
  }
  const std::int64_t began = now_ns_ ? now_ns_() : 0;
  run_handler(event);
  const std::int64_t took = now_ns_ ? now_ns_() - began : 0;
  handler_ns_ += took;
  if (sink_ && !outbox_.empty()) {
    scratch_.clear();
    encode_outputs(steps_, took, outbox_, scratch_);
    sink_->append(WalKind::kOutputs, scratch_);
    if (outbox_.wants_durable()) sink_->sync();
  }
  apply_timers();
  ++steps_;
  return outbox_;
}

const Outbox& NodeHost::replay_step(const Event& event) {
  run_handler(event);
  apply_timers();
  ++steps_;
  return outbox_;
}

void NodeHost::run_handler(const Event& e) {
  if (e.kind == EventKind::kStart) {
    incarnation_ = e.incarnation;
    timers_.clear();
    finished_.reset();
  }
  if (e.kind == EventKind::kWake) timers_.erase(e.id);
  outbox_.begin(e.now, incarnation_);
  switch (e.kind) {
    case EventKind::kStart:
      node_->start(Start{e.incarnation}, e.now, outbox_);
      break;
    case EventKind::kWake:
      node_->wake(TimerId(e.id), e.now, outbox_);
      break;
    case EventKind::kIo:
      node_->on_io(PortId(e.id), e.bytes, e.now, outbox_);
      break;
    case EventKind::kLink:
      node_->on_link(PortId(e.id), e.link, e.now, outbox_);
      break;
    case EventKind::kLocalStop:
      node_->local_stop({reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size()}, e.now, outbox_);
      break;
    case EventKind::kRefused:
      node_->on_refused(PortId(e.id), {reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size()}, e.now,
                        outbox_);
      break;
    case EventKind::kMessage: {
      const Subscription* read = subscription(e.channel);
      if (!read) return;
      if (const auto why = validate(*read->channel, e.bytes)) return refuse(*why);
      for (const Node::Route* route : read->routes)
        if (!route->deliver(e.bytes, e.now, outbox_))
          return refuse(std::string(e.channel) + ": does not decode");
      break;
    }
  }
}

void NodeHost::refuse(const std::string& why) { outbox_.report(Severity::kStop, why); }

void NodeHost::apply_timers() {
  for (std::size_t n = 0; n < outbox_.size(); ++n) {
    const Output o = outbox_.at(n);
    if (o.kind == OutputKind::kArm) timers_[o.id] = o.at;
    if (o.kind == OutputKind::kCancel) timers_.erase(o.id);
    if (o.kind == OutputKind::kFinish && !finished_) {
      finished_ = int(o.id);
      finish_reason_.assign(reinterpret_cast<const char*>(o.bytes.data()), o.bytes.size());
    }
  }
}

std::optional<NodeHost::Armed> NodeHost::next_timer() const {
  std::optional<Armed> first;
  for (const auto& [id, at] : timers_)
    if (!first || at < first->at) first = Armed{TimerId(id), at};
  return first;
}

bool NodeHost::is_armed(TimerId timer, Time at) const {
  const auto it = timers_.find(std::uint32_t(timer));
  return it != timers_.end() && it->second == at;
}

}  // namespace firn
