#include "runtime/transport_sender.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "files/record/checksum.h"

namespace firn {
namespace {

constexpr std::int64_t kResendGuardUs = 10'000;  // two askers, one answer
constexpr std::int64_t kMaxPerRange = 1024;
constexpr std::size_t kMaxBacklogBytes = std::size_t(32) << 20;  // a request beyond this is asked again later

}  // namespace

TransportSender::TransportSender(const TransportOptions& options, Transport::Fetch fetch)
    : options_(options), fetch_(std::move(fetch)) {}

TransportSender::Ring& TransportSender::ring(std::string_view channel) {
  auto it = rings_.find(channel);
  if (it == rings_.end()) {
    const ChannelInfo* row = find_channel(channel);
    if (!row || row->publisher != options_.self)
      throw std::logic_error(std::string(info(options_.self).name) + " must not publish " +
                             std::string(channel));
    it = rings_.emplace(row->name, Ring{}).first;
    it->second.name = row->name;
    it->second.tiles_name = std::string(row->name) + std::string(wire::kTilesSuffix);
    it->second.reliable = row->delivery == Delivery::kReliable;
  }
  return it->second;
}

TransportSender::Bytes TransportSender::keep(Ring& r, std::span<const std::byte> message) {
  const auto header = wire::read_header(message);
  if (!header || header->run_id != options_.run_id)
    throw std::logic_error(std::string(r.name) + ": a message without a header of this run");
  if (message.size() > wire::kLargestObjectBytes)
    throw std::logic_error(std::string(r.name) + ": a message of " + std::to_string(message.size()) +
                           " bytes, at most " + std::to_string(wire::kLargestObjectBytes));
  auto bytes = std::make_shared<const std::vector<std::byte>>(message.begin(), message.end());
  if (!r.reliable) return bytes;
  if (header->seq != r.last + 1)
    throw std::logic_error(std::string(r.name) + ": seq " + std::to_string(header->seq) + " after " +
                           std::to_string(r.last));
  r.last = header->seq;
  r.sent.push_back({header->seq, bytes, 0});
  order_.push_back(&r);
  kept_bytes_ += bytes->size();
  while (kept_bytes_ > options_.ring_bytes && order_.size() > 1) {
    Ring& oldest = *order_.front();
    order_.pop_front();
    kept_bytes_ -= oldest.sent.front().bytes->size();
    oldest.sent.pop_front();
  }
  return bytes;
}

void TransportSender::restore(std::string_view channel, std::span<const std::byte> message) {
  keep(ring(channel), message);
}

void TransportSender::send(std::string_view channel, std::span<const std::byte> message) {
  Ring& r = ring(channel);
  queue(r, keep(r, message), false);
}

void TransportSender::send_once(std::string_view channel, std::vector<std::byte> message) {
  queue(ring(channel), std::make_shared<const std::vector<std::byte>>(std::move(message)), false);
}

void TransportSender::queue(const Ring& r, Bytes bytes, bool again) {
  backlog_bytes_ += bytes->size();
  if (bytes->size() <= wire::kLargestWholeBytes) {
    (again ? paced_ : at_once_).push_back({&r, std::move(bytes)});
    return;
  }
  const std::uint64_t checksum = record::checksum64(*bytes);
  const std::int32_t tiles = wire::tile_count(bytes->size());
  for (std::int32_t n = 0; n < tiles; ++n) paced_.push_back({&r, bytes, n, checksum});
}

void TransportSender::resend(const wire::SeqRange& range, std::int64_t wall_us) {
  const auto it = rings_.find(range.channel);
  if (it == rings_.end() || !it->second.reliable || range.from < 1 || range.to < range.from) return;
  Ring& r = it->second;
  const std::int64_t first = r.sent.empty() ? r.last + 1 : r.sent.front().seq;
  const std::int64_t to = std::min(range.to, r.last);
  for (std::int64_t seq = range.from, n = 0; seq <= to && n < kMaxPerRange; ++seq, ++n) {
    if (backlog_bytes_ > kMaxBacklogBytes) return;
    if (seq >= first) {
      Sent& s = r.sent[std::size_t(seq - first)];
      if (s.resent_us != 0 && wall_us - s.resent_us < kResendGuardUs) continue;
      s.resent_us = wall_us;
      queue(r, s.bytes, true);
    } else {
      std::vector<std::byte> bytes;
      if (!fetch_ || !fetch_(r.name, seq, bytes)) continue;
      queue(r, std::make_shared<const std::vector<std::byte>>(std::move(bytes)), true);
    }
    ++resent_;
  }
}

std::int64_t TransportSender::gap_us(std::size_t bytes) const {
  return options_.tile_gap_us * std::int64_t(bytes) / std::int64_t(wire::kTileDataBytes);
}

// The pace is a bucket of burst_bytes that fills as time goes [ITU-T I.371, generic cell rate algorithm]:
// paced_ready_us_ is the time at which all bytes sent would be through at the pace, or so much before it.
bool TransportSender::next(std::int64_t wall_us, Transport::Datagram& out) {
  if (!at_once_.empty()) {
    current_ = std::move(at_once_.front());
    at_once_.pop_front();
  } else if (!paced_.empty() && wall_us >= paced_ready_us_) {
    current_ = std::move(paced_.front());
    paced_.pop_front();
    // Small messages that are sent again follow each other in proportion to their size.
    const auto size = std::min(current_.bytes->size(), wire::kTileDataBytes);
    paced_ready_us_ = std::max(paced_ready_us_, wall_us - gap_us(options_.burst_bytes)) + gap_us(size);
  } else {
    return false;
  }
  const Waiting& w = current_;
  if (w.tile < 0) {
    backlog_bytes_ -= w.bytes->size();
    out = {w.ring->name, *w.bytes};
    return true;
  }
  const auto header = wire::read_header(*w.bytes);
  const std::size_t begin = std::size_t(w.tile) * wire::kTileDataBytes;
  const auto data =
      std::span(*w.bytes).subspan(begin, std::min(wire::kTileDataBytes, w.bytes->size() - begin));
  backlog_bytes_ -= data.size();
  current_tile_ =
      wire::encode_tile({header->run_id, header->incarnation, header->seq, w.tile,
                         wire::tile_count(w.bytes->size()), std::int64_t(w.bytes->size()), w.checksum, data});
  out = {w.ring->tiles_name, current_tile_};
  return true;
}

std::int64_t TransportSender::due_us(std::int64_t wall_us) const {
  if (!at_once_.empty()) return wall_us;
  return paced_.empty() ? std::numeric_limits<std::int64_t>::max() : paced_ready_us_;
}

std::vector<Transport::Last> TransportSender::last_sent() const {
  std::vector<Transport::Last> list;
  for (const auto& [name, r] : rings_)
    if (r.reliable && r.last > 0) list.push_back({name, r.last});
  return list;
}

}  // namespace firn
