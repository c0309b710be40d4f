#include "runtime/relay/send_queue.h"

#include <algorithm>
#include <functional>

#include "lcmtypes/channels.h"
#include "runtime/port_rate.h"

namespace firn::relay {
namespace {

constexpr std::int64_t kPeriodNs = 200'000'000;
constexpr std::size_t kPeriods = 10;
constexpr double kAhead = 1.5;
constexpr double kQueueNs = 10e6;      // on top of the round trip, for the other side's own work
constexpr std::size_t kMacBytes = 32;  // of a sealed datagram (procs/bus/message_mac.h)

}  // namespace

bool goes_at_once(std::string_view channel) {
  return channel == channels::kEnable.name || channel == channels::kSafeStop.name ||
         channel.starts_with("FAULT_") || channel.starts_with("HEARTBEAT_") || channel.starts_with("RESEND_");
}

bool goes_in_turn(const Frame& f) {
  if (f.kind == FrameKind::kDatagram) return !goes_at_once(f.name);
  if (f.kind == FrameKind::kPort) return port_rate(f.name).bytes_per_s > kMostAtOnce;
  return f.kind == FrameKind::kFile;
}

void SendQueue::add(const Frame& f) {
  Waiting w;
  w.counts = f.kind == FrameKind::kDatagram || goes_in_turn(f);
  const bool first = !goes_in_turn(f);
  std::deque<Waiting>& queue = first ? at_once_ : in_turn_;
  std::size_t& bytes = first ? at_once_bytes_ : in_turn_bytes_;
  if (f.kind == FrameKind::kDatagram) {
    const ChannelInfo* const row = find_channel(f.name);
    if (row && row->delivery == Delivery::kLatest) {
      w.latest = f.name;
      const auto older = std::ranges::find(queue, w.latest, &Waiting::latest);
      if (older != queue.end()) {
        bytes -= older->frame.size();
        older->frame.clear();
        append_frame(f, older->frame);
        bytes += older->frame.size();
        return;
      }
    } else if (f.bytes.size() > kMacBytes) {
      const std::string_view message = f.text().substr(0, f.bytes.size() - kMacBytes);
      w.digest = std::hash<std::string_view>{}(message) ^ (std::hash<std::string_view>{}(f.name) << 1);
      if (w.digest != 0 && !waiting_messages_.insert(w.digest).second) return;
    }
    if (bytes + f.bytes.size() > kMostWaitingBytes) {
      waiting_messages_.erase(w.digest);
      ++dropped_;
      return;
    }
  }
  append_frame(f, w.frame);
  bytes += w.frame.size();
  queue.push_back(std::move(w));
}

void SendQueue::leave(Waiting& w, std::vector<std::byte>& to) {
  to.insert(to.end(), w.frame.begin(), w.frame.end());
  if (w.counts) sent_ += std::int64_t(w.frame.size());
  if (w.digest != 0) waiting_messages_.erase(w.digest);
}

bool SendQueue::next(std::int64_t now_ns, std::size_t most, std::vector<std::byte>& to) {
  if (period_began_ns_ == 0) period_began_ns_ = now_ns;
  const std::size_t before = to.size();
  while (!at_once_.empty() && to.size() - before < most) {
    at_once_bytes_ -= at_once_.front().frame.size();
    leave(at_once_.front(), to);
    at_once_.pop_front();
  }
  while (!in_turn_.empty() && has_room() && to.size() - before < most) {
    in_turn_bytes_ -= in_turn_.front().frame.size();
    leave(in_turn_.front(), to);
    in_turn_.pop_front();
  }
  while (files_ && in_turn_.empty() && has_room() && to.size() - before < most) {
    file_frame_.clear();
    if (!files_(file_frame_)) break;
    to.insert(to.end(), file_frame_.begin(), file_frame_.end());
    sent_ += std::int64_t(file_frame_.size());
  }
  return to.size() > before;
}

void SendQueue::taken(std::int64_t bytes, std::int64_t now_ns) {
  if (bytes < acknowledged_ || bytes > sent_) return;  // of a broken relay
  period_bytes_ += bytes - acknowledged_;
  acknowledged_ = bytes;
  if (now_ns < period_began_ns_ + kPeriodNs) return;
  rates_.push_back(double(period_bytes_) / double(now_ns - period_began_ns_));
  if (rates_.size() > kPeriods) rates_.pop_front();
  period_began_ns_ = now_ns;
  period_bytes_ = 0;
  const double quickest = *std::ranges::max_element(rates_);
  window_ = std::clamp(std::int64_t(kAhead * quickest * (double(round_trip_ns_) + kQueueNs)), kLeastWindow,
                       kMostWindow);
}

}  // namespace firn::relay
