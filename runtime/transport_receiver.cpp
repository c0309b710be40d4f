#include "runtime/transport_receiver.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "files/record/checksum.h"

namespace firn {
namespace {

constexpr std::int64_t kWindow = 1 << 16;     // messages kept ahead of the next one
constexpr std::int64_t kPlausible = 1 << 22;  // a larger jump is no loss but nonsense
constexpr std::size_t kMaxPartials = 64;      // objects in pieces, per channel
constexpr std::size_t kMaxNotices = 64;
constexpr std::size_t kMaxRanges = 16;    // asked for at once, per channel
constexpr std::int64_t kMaxAsked = 1024;  // messages, per channel
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

}  // namespace

TransportReceiver::TransportReceiver(const TransportOptions& options, Transport::Deliver deliver)
    : options_(options), deliver_(std::move(deliver)) {}

void TransportReceiver::subscribe(const ChannelInfo& row) {
  In& in = in_[std::string(row.name)];
  in.row = &row;
  in.reliable = row.delivery == Delivery::kReliable;
  tiles_[std::string(row.name) + std::string(wire::kTilesSuffix)] = &in;
}

std::vector<std::string> TransportReceiver::wire_channels() const {
  std::vector<std::string> names;
  for (const auto& [name, _] : in_) names.push_back(name);
  for (const auto& [name, _] : tiles_) names.push_back(name);
  return names;
}

std::set<NodeId> TransportReceiver::reliable_publishers() const {
  std::set<NodeId> publishers;
  for (const auto& [name, in] : in_)
    if (in.reliable) publishers.insert(in.row->publisher);
  return publishers;
}

void TransportReceiver::restore(std::string_view channel, std::span<const std::byte> message) {
  const auto it = in_.find(channel);
  const auto header = wire::read_header(message);
  if (it == in_.end() || !header) return;
  In& in = it->second;
  std::string why = jumps_.restore(*in.row, *header, message);
  if (header->incarnation > options_.incarnation)
    why = "it is of incarnation " + std::to_string(header->incarnation) + ", and this one is " +
          std::to_string(options_.incarnation);
  if (!why.empty())
    throw std::runtime_error(std::string(in.row->name) + ", message " + std::to_string(header->seq) +
                             ", which was taken before: " + why + "; this run cannot go on");
  in.delivered = std::max(in.delivered, header->seq);
  in.incarnation = std::max(in.incarnation, header->incarnation);
  in.known = in.counted = in.delivered;
}

bool TransportReceiver::receive(std::string_view channel, std::span<const std::byte> datagram,
                                std::int64_t wall_us) {
  if (const auto it = in_.find(channel); it != in_.end()) {
    whole(it->second, datagram, wall_us);
    return true;
  }
  if (const auto it = tiles_.find(channel); it != tiles_.end()) {
    tile(*it->second, datagram, wall_us);
    return true;
  }
  return false;
}

void TransportReceiver::whole(In& in, std::span<const std::byte> message, std::int64_t wall_us) {
  const auto header = wire::read_header(message);
  if (!header) return malformed(in.row->name, "no header");
  if (foreign(header->run_id, header->incarnation, in.row->name)) return;
  if (wanted(in, header->incarnation, header->seq, wall_us)) accept(in, *header, message, wall_us);
}

void TransportReceiver::tile(In& in, std::span<const std::byte> datagram, std::int64_t wall_us) {
  const auto t = wire::read_tile(datagram);
  if (!t) return malformed(in.row->name, "a tile whose numbers do not fit");
  if (foreign(t->run_id, t->incarnation, in.row->name) || !wanted(in, t->incarnation, t->seq, wall_us))
    return;

  auto it = in.partial.find(t->seq);
  if (it != in.partial.end() &&
      (it->second.total_bytes != t->total_bytes || it->second.checksum != t->checksum ||
       it->second.incarnation != t->incarnation)) {
    malformed(in.row->name, "tiles of one message disagree");
    forget_partial(in, it);
    it = in.partial.end();
  }
  const bool is_next = t->seq == in.delivered + 1 || !in.reliable;
  while (is_next && held_bytes_ > options_.window_bytes && !in.partial.empty() &&
         in.partial.rbegin()->first != t->seq)
    forget_partial(in, std::prev(in.partial.end()));
  if (!is_next && held_bytes_ > options_.window_bytes) return;  // it will be asked for again
  if (it == in.partial.end()) {
    if (in.partial.size() >= kMaxPartials) {
      const auto furthest = std::prev(in.partial.end());
      if (furthest->first < t->seq) return;
      forget_partial(in, furthest);
    }
    it = in.partial.emplace(t->seq, Partial{t->incarnation, t->total_bytes, t->checksum, wall_us, 0, {}})
             .first;
    it->second.tiles.resize(std::size_t(t->count));
  }
  Partial& p = it->second;
  std::vector<std::byte>& place = p.tiles[std::size_t(t->index)];
  if (!place.empty()) {
    ++stats.duplicates;
    return;
  }
  place.assign(t->data.begin(), t->data.end());
  held_bytes_ += place.size();
  p.last_us = wall_us;
  if (++p.have < t->count) return;

  std::vector<std::byte> message;
  message.reserve(std::size_t(p.total_bytes));
  for (const auto& piece : p.tiles) message.insert(message.end(), piece.begin(), piece.end());
  const bool sound = record::checksum64(message) == p.checksum;
  forget_partial(in, it);
  const auto header = wire::read_header(message);
  if (!sound || !header || header->run_id != t->run_id || header->seq != t->seq ||
      header->incarnation != t->incarnation)
    return malformed(in.row->name, "joined tiles are not the message that was announced");
  accept(in, *header, message, wall_us);
}

bool TransportReceiver::wanted(In& in, std::int32_t incarnation, std::int64_t seq, std::int64_t wall_us) {
  if (!in.reliable) {
    const bool newer = incarnation > in.incarnation || (incarnation == in.incarnation && seq > in.delivered);
    if (!newer) ++stats.stale;
    if (newer && seq - in.delivered > kPlausible) {
      malformed(in.row->name, "a sequence number far ahead");
      return false;
    }
    return newer;
  }
  if (seq <= in.delivered || in.ahead.count(seq) != 0) {
    ++stats.duplicates;
    return false;
  }
  if (incarnation < in.incarnation) {
    malformed(in.row->name, "an incarnation that went back");
    return false;
  }
  if (seq - in.delivered > kPlausible) {
    malformed(in.row->name, "a sequence number far ahead");
    return false;
  }
  know(in, seq, wall_us);
  return seq - in.delivered <= kWindow;
}

void TransportReceiver::know(In& in, std::int64_t seq, std::int64_t wall_us) {
  if (in.known <= in.delivered) {  // nothing was missing until now
    in.quiet_us = wall_us;
    in.asked_times = 0;
  }
  in.known = std::max(in.known, seq);
}

void TransportReceiver::accept(In& in, const wire::Header& header, std::span<const std::byte> message,
                               std::int64_t wall_us) {
  if (!in.reliable) {
    if (message.size() > 0 && !in.partial.empty()) {  // pieces of older ones are worth nothing now
      while (!in.partial.empty() && in.partial.begin()->first <= header.seq)
        forget_partial(in, in.partial.begin());
    }
    if (!follows(in, header, message)) return;
    in.delivered = header.seq;
    in.incarnation = header.incarnation;
    ++stats.delivered;
    deliver_(*in.row, message);
    return;
  }
  if (header.seq != in.delivered + 1) {
    if (held_bytes_ > options_.window_bytes) return;
    held_bytes_ += message.size();
    in.ahead.emplace(header.seq, std::vector<std::byte>(message.begin(), message.end()));
    return;
  }
  if (!hand_on(in, header, message)) return;
  for (bool taken = true; taken && !in.ahead.empty() && in.ahead.begin()->first == in.delivered + 1;) {
    const auto next = in.ahead.extract(in.ahead.begin());
    held_bytes_ -= next.mapped().size();
    taken = hand_on(in, *wire::read_header(next.mapped()), next.mapped());
  }
  in.quiet_us = wall_us;
  in.asked_times = 0;
}

bool TransportReceiver::follows(const In& in, const wire::Header& header,
                                std::span<const std::byte> message) {
  const std::string why = jumps_.take(*in.row, header, message);
  if (why.empty()) return true;
  ++stats.malformed;
  notice_once(std::string(in.row->name) + " jumps", std::string(in.row->name) + ": " + why + ", dropped");
  return false;
}

bool TransportReceiver::hand_on(In& in, const wire::Header& header, std::span<const std::byte> message) {
  if (!follows(in, header, message)) return false;
  in.delivered = header.seq;
  in.incarnation = std::max(in.incarnation, header.incarnation);
  in.known = std::max(in.known, in.delivered);
  if (const auto it = in.partial.find(header.seq); it != in.partial.end()) forget_partial(in, it);
  ++stats.delivered;
  deliver_(*in.row, message);
  return true;
}

void TransportReceiver::heartbeat(std::span<const std::byte> message, const NodeInfo& publisher,
                                  std::int64_t wall_us) {
  const auto list = wire::read_heartbeat(message);
  if (!list) return malformed("HEARTBEAT of " + std::string(publisher.name), "it does not decode");
  for (const wire::LastSeq& last : *list) {
    const auto it = in_.find(last.channel);
    if (it == in_.end() || !it->second.reliable || it->second.row->publisher != publisher.id) continue;
    In& in = it->second;
    if (last.seq < 0 || last.seq - in.delivered > kPlausible) {
      malformed(in.row->name, "a heartbeat with a sequence number far ahead");
      continue;
    }
    // The publisher knows best: a claim of more than it sent is forgotten here, at worst until its next
    // message.
    in.known = std::max(in.delivered, in.ahead.empty() ? 0 : in.ahead.rbegin()->first);
    know(in, last.seq, wall_us);
  }
}

std::int64_t TransportReceiver::ask_at(const In& in) const {
  if (!in.reliable || in.known <= in.delivered) return kNever;
  const std::int64_t calm = in.quiet_us + options_.patience_us;
  if (in.asked_times == 0) return calm;
  return std::max(calm, in.asked_us + (options_.ask_again_us << std::min(in.asked_times - 1, 4)));
}

std::vector<wire::SeqRange> TransportReceiver::to_ask(std::int64_t wall_us) {
  std::vector<wire::SeqRange> ranges;
  for (auto& [name, in] : in_) {
    if (ask_at(in) > wall_us) continue;
    std::int64_t seq = in.delivered + 1, asked = 0;
    const std::int64_t end = std::min(in.known, in.delivered + kWindow);
    auto next = in.ahead.begin();
    const std::size_t before = ranges.size();
    while (seq <= end && asked < kMaxAsked && ranges.size() - before < kMaxRanges) {
      if (next != in.ahead.end() && next->first == seq) {
        ++next;
        ++seq;
        continue;
      }
      const auto p = in.partial.find(seq);  // its tiles are still coming in
      if (p != in.partial.end() && wall_us - p->second.last_us < options_.patience_us) {
        ++seq;
        continue;
      }
      std::int64_t to = next == in.ahead.end() ? end : std::min(end, next->first - 1);
      if (const auto q = in.partial.upper_bound(seq); q != in.partial.end()) to = std::min(to, q->first - 1);
      if (p != in.partial.end()) to = seq;
      to = std::min(to, seq + kMaxAsked - asked - 1);
      ranges.push_back({in.row->name, seq, to});
      if (to > in.counted) stats.missing += std::uint64_t(to - std::max(in.counted, seq - 1));
      in.counted = std::max(in.counted, to);
      asked += to - seq + 1;
      seq = to + 1;
    }
    if (ranges.size() > before) {
      in.asked_us = wall_us;
      ++in.asked_times;
    } else {
      in.quiet_us = wall_us;
    }
  }
  return ranges;
}

std::int64_t TransportReceiver::due_us() const {
  std::int64_t due = kNever;
  for (const auto& [_, in] : in_) due = std::min(due, ask_at(in));
  return due;
}

bool TransportReceiver::foreign(std::int64_t run_id, std::int32_t incarnation, std::string_view channel) {
  if (run_id == options_.run_id && incarnation <= options_.incarnation) return false;
  ++stats.foreign;
  if (run_id != options_.run_id)
    notice_once("run " + std::to_string(run_id), std::string(channel) + ": messages of run " +
                                                     std::to_string(run_id) + " on the port of run " +
                                                     std::to_string(options_.run_id) + ", dropped");
  else
    notice_once("incarnation", std::string(channel) + ": incarnation " + std::to_string(incarnation) +
                                   " of this run, which is at " + std::to_string(options_.incarnation) +
                                   ", dropped");
  return true;
}

void TransportReceiver::malformed(std::string_view channel, std::string_view why) {
  ++stats.malformed;
  const std::string text = std::string(channel) + ": " + std::string(why) + ", dropped";
  notice_once(text, text);
}

void TransportReceiver::notice_once(std::string key, std::string text) {
  if (noticed_.size() < kMaxNotices && noticed_.insert(std::move(key)).second)
    notices.push_back(std::move(text));
}

void TransportReceiver::forget_partial(In& in, std::map<std::int64_t, Partial>::iterator it) {
  for (const auto& piece : it->second.tiles) held_bytes_ -= piece.size();
  in.partial.erase(it);
}

std::int64_t TransportReceiver::last_delivered(std::string_view channel) const {
  const auto it = in_.find(channel);
  return it == in_.end() ? 0 : it->second.delivered;
}

bool TransportReceiver::waiting() const {
  return std::any_of(in_.begin(), in_.end(),
                     [](const auto& e) { return e.second.reliable && e.second.known > e.second.delivered; });
}

}  // namespace firn
