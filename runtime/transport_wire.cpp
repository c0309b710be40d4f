#include "runtime/transport_wire.h"

#include <algorithm>
#include <limits>
#include <string>

#include "firn/heartbeat_t.hpp"
#include "firn/resend_request_t.hpp"
#include "firn/tile_t.hpp"

namespace firn::wire {
namespace {

constexpr std::size_t kTileHeadBytes = 56;

/// Reads big-endian numbers and LCM strings; once something does not fit, ok() stays false and zeros come.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> from) : from_(from) {}

  template <class T>
  T number() {
    std::uint64_t v = 0;
    for (const std::byte b : take(sizeof(T))) v = v << 8 | std::uint64_t(b);
    return T(v);
  }
  std::string_view text() {
    const auto length = number<std::int32_t>();  // includes the final zero byte
    if (length < 1) ok_ = false;
    const auto bytes = take(ok_ ? std::size_t(length) : 0);
    return ok_ ? std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1)
               : std::string_view{};
  }
  std::span<const std::byte> take(std::size_t n) {
    if (!ok_ || n > from_.size() - at_) {
      ok_ = false;
      return {};
    }
    at_ += n;
    return from_.subspan(at_ - n, n);
  }
  bool ok() const { return ok_; }
  bool done() const { return ok_ && at_ == from_.size(); }
  std::size_t left() const { return from_.size() - at_; }

 private:
  std::span<const std::byte> from_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

bool starts_with(Reader& r, std::int64_t fingerprint) {
  return r.number<std::int64_t>() == fingerprint && r.ok();
}

}  // namespace

std::optional<Header> read_header(std::span<const std::byte> message) {
  Reader r(message);
  r.number<std::int64_t>();
  Header h;
  h.run_id = r.number<std::int64_t>();
  h.incarnation = r.number<std::int32_t>();
  h.seq = r.number<std::int64_t>();
  h.utime_us = r.number<std::int64_t>();
  if (!r.ok() || h.incarnation < 0 || h.seq < 1) return std::nullopt;
  return h;
}

std::int32_t tile_count(std::size_t total) {
  return std::int32_t((total + kTileDataBytes - 1) / kTileDataBytes);
}

std::optional<Tile> read_tile(std::span<const std::byte> datagram) {
  Reader r(datagram);
  if (!starts_with(r, tile_t::getHash())) return std::nullopt;
  Tile t;
  const auto size = r.number<std::int32_t>();
  t.run_id = r.number<std::int64_t>();
  t.incarnation = r.number<std::int32_t>();
  t.seq = r.number<std::int64_t>();
  t.index = r.number<std::int32_t>();
  t.count = r.number<std::int32_t>();
  t.total_bytes = r.number<std::int64_t>();
  t.checksum = r.number<std::uint64_t>();
  if (!r.ok() || size < 1 || t.incarnation < 0 || t.seq < 1) return std::nullopt;
  if (t.total_bytes < 1 || t.total_bytes > std::int64_t(kLargestObjectBytes)) return std::nullopt;
  if (t.count != tile_count(std::size_t(t.total_bytes)) || t.index < 0 || t.index >= t.count)
    return std::nullopt;
  const std::size_t begin = std::size_t(t.index) * kTileDataBytes;
  if (std::size_t(size) != std::min(kTileDataBytes, std::size_t(t.total_bytes) - begin)) return std::nullopt;
  t.data = r.take(std::size_t(size));
  if (!r.done()) return std::nullopt;
  return t;
}

std::vector<std::byte> encode_tile(const Tile& t) {
  std::vector<std::byte> out;
  out.reserve(kTileHeadBytes + t.data.size());
  const auto put = [&](auto v) {
    for (int shift = int(sizeof v) * 8 - 8; shift >= 0; shift -= 8)
      out.push_back(std::byte(std::uint64_t(v) >> shift));
  };
  put(tile_t::getHash());
  put(std::int32_t(t.data.size()));
  put(t.run_id);
  put(t.incarnation);
  put(t.seq);
  put(t.index);
  put(t.count);
  put(t.total_bytes);
  put(t.checksum);
  out.insert(out.end(), t.data.begin(), t.data.end());
  return out;
}

std::optional<std::vector<LastSeq>> read_heartbeat(std::span<const std::byte> message) {
  Reader r(message);
  if (!starts_with(r, heartbeat_t::getHash())) return std::nullopt;
  r.take(kHeaderEnd - 8);
  const auto n = r.number<std::int32_t>();
  r.text();                            // node
  r.take(1 + 4 * 8);                   // state, busy_since_us, steps, lost, resent
  constexpr std::size_t kMin = 5 + 8;  // an empty name and a number
  if (!r.ok() || n < 0 || std::size_t(n) > r.left() / kMin) return std::nullopt;
  std::vector<LastSeq> list(std::size_t(n), LastSeq{});
  for (LastSeq& l : list) l.channel = r.text();
  for (LastSeq& l : list) l.seq = r.number<std::int64_t>();
  if (!r.done()) return std::nullopt;
  return list;
}

std::optional<std::vector<SeqRange>> read_resend_request(std::span<const std::byte> message) {
  Reader r(message);
  if (!starts_with(r, resend_request_t::getHash())) return std::nullopt;
  r.take(kHeaderEnd - 8);
  const auto n = r.number<std::int32_t>();
  r.text();  // node
  constexpr std::size_t kMin = 5 + 16;
  if (!r.ok() || n < 0 || std::size_t(n) > r.left() / kMin) return std::nullopt;
  std::vector<SeqRange> list(std::size_t(n), SeqRange{});
  for (SeqRange& s : list) s.channel = r.text();
  for (SeqRange& s : list) s.from = r.number<std::int64_t>();
  for (SeqRange& s : list) s.to = r.number<std::int64_t>();
  if (!r.done()) return std::nullopt;
  return list;
}

std::vector<std::byte> encode_resend_request(const Header& h, std::string_view node,
                                             std::span<const SeqRange> ranges) {
  resend_request_t m{};
  m.header.run_id = h.run_id;
  m.header.incarnation = h.incarnation;
  m.header.seq = h.seq;
  m.header.utime_us = h.utime_us;
  m.n = std::int32_t(ranges.size());
  m.node = node;
  for (const SeqRange& s : ranges) {
    m.channel.emplace_back(s.channel);
    m.from_seq.push_back(s.from);
    m.to_seq.push_back(s.to);
  }
  std::vector<std::byte> out(std::size_t(m.getEncodedSize()));
  m.encode(out.data(), 0, int(out.size()));
  return out;
}

}  // namespace firn::wire
