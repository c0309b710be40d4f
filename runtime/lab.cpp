#include "runtime/lab.h"

#include <algorithm>
#include <functional>

namespace firn {
namespace {

std::size_t place_of(const ChannelInfo& channel) { return std::size_t(&channel - channel_table().data()); }

}  // namespace

void Lab::add(NodeHost* host) {
  const int node = int(hosts_.size());
  hosts_.push_back(host);
  armed_.push_back(host->next_timer());
  readers_.resize(channel_table().size());
  for (const std::string_view channel : host->channels())
    readers_[place_of(*find_channel(channel))].push_back(node);
  std::uint32_t port = 0;
  for (std::string& name : host->ports()) ports_.push_back({std::move(name), node, port++, false});
}

void Lab::start(std::int32_t incarnation, Time now) {
  now_ = now;
  Event e;
  e.kind = EventKind::kStart;
  e.now = now;
  e.incarnation = incarnation;
  for (int n = 0; n < int(hosts_.size()); ++n) dispatch(n, e);
  for (PortOwner& p : ports_) {
    if (p.open) continue;  // by its node, at the start
    world_->connect(p.name, now);
    p.open = true;
    push({now, p.node, 0, EventKind::kLink, p.port, LinkState::kOpen, {}, nullptr});
  }
}

void Lab::publish(std::string_view channel, std::span<const std::byte> bytes) { deliver(channel, bytes); }

void Lab::publish_to(NodeId node, std::string_view channel, std::span<const std::byte> bytes) {
  for (int n = 0; n < int(hosts_.size()); ++n)
    if (hosts_[std::size_t(n)]->id() == node && hosts_[std::size_t(n)]->subscribes(channel))
      push({now_, n, 0, EventKind::kMessage, 0, LinkState::kClosed, find_channel(channel)->name,
            std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end())});
}

Lab::End Lab::run(std::span<const NodeId> must_finish, Time limit) {
  const auto finished = [&] {
    return std::all_of(must_finish.begin(), must_finish.end(), [&](NodeId id) {
      return std::any_of(hosts_.begin(), hosts_.end(),
                         [&](NodeHost* h) { return h->id() == id && h->finished(); });
    });
  };
  while (!finished())
    if (!step(limit)) return now_ >= limit ? End::kTimeLimit : End::kIdle;
  return End::kFinished;
}

bool Lab::step(Time limit) {
  // Nature first: bytes that an instrument sends at time t reach a node that wakes at t.
  const Time world = world_ ? world_->next_event() : Time::never();
  int timer_node = -1;
  NodeHost::Armed timer{};
  for (int n = 0; n < int(hosts_.size()); ++n)
    if (const auto& armed = armed_[std::size_t(n)]; armed && (timer_node < 0 || armed->at < timer.at)) {
      timer_node = n;
      timer = *armed;
    }
  Time next = world;
  if (!queue_.empty()) next = std::min(next, queue_.front().at);
  if (timer_node >= 0) next = std::min(next, std::max(timer.at, now_));
  if (next == Time::never()) return false;
  if (next > limit) {
    now_ = limit;
    return false;
  }
  now_ = std::max(now_, next);
  if (world <= now_) {
    run_world();
    return true;
  }
  const bool queue_due = !queue_.empty() && queue_.front().at <= now_;
  if (queue_due && (timer_node < 0 || timer.at > now_ || queue_.front().node <= timer_node)) {
    std::ranges::pop_heap(queue_, std::greater{});
    const Pending p = std::move(queue_.back());
    queue_.pop_back();
    Event e;
    e.kind = p.kind;
    e.now = now_;
    e.channel = p.channel;
    e.id = p.port;
    e.link = p.link;
    if (p.bytes) e.bytes = *p.bytes;
    dispatch(p.node, e);
  } else {
    Event e;
    e.kind = EventKind::kWake;
    e.now = now_;
    e.id = std::uint32_t(timer.timer);
    e.due = timer.at;
    dispatch(timer_node, e);
  }
  return true;
}

void Lab::dispatch(int node, const Event& event) {
  ++steps_;
  NodeHost& host = *hosts_[std::size_t(node)];
  const Outbox& outbox = host.step(event);
  armed_[std::size_t(node)] = host.next_timer();
  carry_out(node, outbox);
}

void Lab::carry_out(int node, const Outbox& outbox) {
  std::vector<std::pair<std::uint32_t, std::string>> refused;  // port, cause
  const NodeHost& host = *hosts_[std::size_t(node)];
  for (std::size_t n = 0; n < outbox.size(); ++n) {
    const Output o = outbox.at(n);
    if (o.kind == OutputKind::kSend) {
      deliver(o.channel, o.bytes);
    } else if (o.kind == OutputKind::kWrite || o.kind == OutputKind::kReopen) {
      const auto port = std::find_if(ports_.begin(), ports_.end(),
                                     [&](const PortOwner& p) { return p.node == node && p.port == o.id; });
      if (port == ports_.end()) continue;
      if (o.kind == OutputKind::kWrite) {
        if (std::string why = host.writes_need_lease() ? host.lease_refusal(now_, 0) : ""; !why.empty()) {
          refused.emplace_back(o.id, std::move(why));
          continue;
        }
        world_->receive(port->name, o.bytes, now_);
      } else {
        // Closed is told only of a port that was open, as live.
        if (port->open) {
          world_->disconnect(port->name, now_);
          push({now_, node, 0, EventKind::kLink, o.id, LinkState::kClosed, {}, nullptr});
        }
        world_->connect(port->name, now_);
        port->open = true;
        push({now_, node, 0, EventKind::kLink, o.id, LinkState::kOpen, {}, nullptr});
      }
    }
  }
  for (const auto& [port, why] : refused) {
    Event e;
    e.kind = EventKind::kRefused;
    e.now = now_;
    e.id = port;
    e.bytes = std::as_bytes(std::span(why));
    dispatch(node, e);
  }
}

void Lab::deliver(std::string_view channel, std::span<const std::byte> bytes) {
  if (tap_) tap_(channel, bytes, now_);
  const ChannelInfo* row = find_channel(channel);
  if (!row || readers_.empty()) return;
  const std::vector<int>& readers = readers_[place_of(*row)];
  if (readers.empty()) return;
  const auto shared = std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
  for (const int n : readers)
    push({now_, n, 0, EventKind::kMessage, 0, LinkState::kClosed, row->name, shared});
}

void Lab::push(Pending p) {
  p.seq = ++seq_;
  queue_.push_back(std::move(p));
  std::ranges::push_heap(queue_, std::greater{});
}

void Lab::run_world() {
  world_->advance(now_, [&](std::string_view port, std::span<const std::byte> bytes, Time at, bool close) {
    for (PortOwner& p : ports_) {
      if (p.name != port) continue;
      if (close) p.open = false;
      push({std::max(at, now_),
            p.node,
            0,
            close ? EventKind::kLink : EventKind::kIo,
            p.port,
            LinkState::kClosed,
            {},
            std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end())});
    }
  });
}

}  // namespace firn
