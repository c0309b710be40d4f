#include "runtime/transport.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "runtime/transport_receiver.h"
#include "runtime/transport_sender.h"

namespace firn {
namespace {

constexpr std::string_view kHeartbeat = "HEARTBEAT_";
constexpr std::string_view kResend = "RESEND_";

}  // namespace

Transport::Transport(const TransportOptions& options, Deliver deliver, Fetch fetch)
    : options_(options),
      receiver_(std::make_unique<TransportReceiver>(options, std::move(deliver))),
      sender_(std::make_unique<TransportSender>(options, std::move(fetch))) {}

Transport::~Transport() = default;

void Transport::subscribe(std::string_view channel) {
  const ChannelInfo* row = find_channel(channel);
  if (!row) throw std::invalid_argument("channel " + std::string(channel) + " is not in the channel table");
  receiver_->subscribe(*row);
}

std::vector<std::string> Transport::wire_channels() const {
  const auto own = receiver_->wire_channels();
  std::set<std::string> names(own.begin(), own.end());
  for (const NodeId publisher : receiver_->reliable_publishers())
    names.emplace(channels::heartbeat(publisher).name);
  for (const ChannelInfo& row : channel_table())
    if (row.publisher != options_.self && row.name.starts_with(kResend)) names.emplace(row.name);
  return {names.begin(), names.end()};
}

void Transport::restore_sent(std::string_view channel, std::span<const std::byte> m) {
  sender_->restore(channel, m);
}
void Transport::restore_received(std::string_view channel, std::span<const std::byte> m) {
  receiver_->restore(channel, m);
}

void Transport::send(std::string_view channel, std::span<const std::byte> m, std::int64_t) {
  sender_->send(channel, m);
}

bool Transport::next_datagram(std::int64_t wall_us, Datagram& out) { return sender_->next(wall_us, out); }
std::size_t Transport::backlog_bytes() const { return sender_->backlog_bytes(); }

void Transport::receive(std::string_view channel, std::span<const std::byte> datagram, std::int64_t wall_us) {
  TransportReceiver& in = *receiver_;
  ++in.stats.datagrams_in;
  in.stats.bytes_in += datagram.size();
  const ChannelInfo* row = nullptr;
  if (channel.starts_with(kHeartbeat) || channel.starts_with(kResend)) row = find_channel(channel);
  if (row && row->publisher != options_.self) {
    const auto header = wire::read_header(datagram);
    if (!header) return in.malformed(channel, "no header");
    if (in.foreign(header->run_id, header->incarnation, channel)) return;
    // A leftover of an earlier incarnation neither knows the sent messages nor may ask.
    if (header->incarnation == options_.incarnation) {
      if (channel.starts_with(kHeartbeat)) {
        in.heartbeat(datagram, info(row->publisher), wall_us);
      } else if (const auto ranges = wire::read_resend_request(datagram)) {
        for (const wire::SeqRange& r : *ranges) sender_->resend(r, wall_us);
      } else {
        in.malformed(channel, "it does not decode");
      }
    }
  }
  if (!in.receive(channel, datagram, wall_us) && !row)
    in.malformed(channel.substr(0, 64), "nobody subscribed to it");
}

void Transport::tick(std::int64_t wall_us) {
  const auto ranges = receiver_->to_ask(wall_us);
  if (ranges.empty()) return;
  wire::Header header{options_.run_id, options_.incarnation, ++request_seq_, 0};
  sender_->send_once(channels::resend_request(options_.self).name,
                     wire::encode_resend_request(header, info(options_.self).name, ranges));
  ++receiver_->stats.requests;
}

std::int64_t Transport::due_us(std::int64_t wall_us) const {
  return std::min(sender_->due_us(wall_us), receiver_->due_us());
}
std::vector<Transport::Last> Transport::last_sent() const { return sender_->last_sent(); }
std::int64_t Transport::last_delivered(std::string_view channel) const {
  return receiver_->last_delivered(channel);
}
bool Transport::waiting() const { return receiver_->waiting(); }

TransportStats Transport::stats() const {
  TransportStats s = receiver_->stats;
  s.resent = sender_->resent();
  return s;
}

std::vector<std::string> Transport::take_notices() { return std::exchange(receiver_->notices, {}); }

}  // namespace firn
