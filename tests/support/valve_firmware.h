// The firmware's side of FVB/1 (drivers/valve/fvb.h), which fake valves answer by.
#pragma once

#include <cstring>

#include "drivers/valve/fvb.h"

namespace firn::drivers::fvb {

template <class T>
T read(std::span<const std::byte> from, std::size_t at) {
  T value;
  std::memcpy(&value, from.data() + at, sizeof value);
  return value;
}

/// Encodes a frame whose payload holds `fields` one after the other.
template <class... T>
void encode_fields(Type type, std::uint8_t seq, std::vector<std::byte>& out, T... fields) {
  std::vector<std::byte> payload;
  const auto add = [&](auto value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    payload.insert(payload.end(), bytes.begin(), bytes.end());
  };
  (add(fields), ...);
  encode(type, seq, payload, out);
}
inline void encode(std::uint8_t seq, const Hello& h, std::vector<std::byte>& out) {
  encode_fields(Type::kHello, seq, out, h.boot_count, h.firmware, h.reset_cause);
}
inline void encode(std::uint8_t seq, const Status& s, std::vector<std::byte>& out) {
  encode_fields(Type::kStatus, seq, out, s.boot_count, s.state, s.path, s.next, s.since_us, s.late_us);
}
inline void encode_ack(std::uint8_t seq, std::uint16_t boot_count, std::vector<std::byte>& out) {
  encode_fields(Type::kAck, seq, out, boot_count);
}
inline void encode_nak(std::uint8_t seq, std::uint16_t boot_count, Refusal refusal,
                       std::vector<std::byte>& out) {
  encode_fields(Type::kNak, seq, out, boot_count, refusal);
}

// Each returns nothing unless the payload has exactly its size and every field its range.
inline std::optional<Begin> parse_begin(std::span<const std::byte> p) {
  if (p.size() != 11) return std::nullopt;
  return Begin{read<std::uint32_t>(p, 0), read<std::uint8_t>(p, 4), read<std::uint16_t>(p, 5),
               read<std::uint16_t>(p, 7), read<std::uint16_t>(p, 9)};
}
struct Data {
  std::uint16_t offset = 0;
  std::size_t entries = 0;
  std::span<const std::byte> ticks;
  std::uint16_t tick(std::size_t n) const {
    return std::uint16_t(std::uint16_t(ticks[2 * n]) | std::uint16_t(ticks[2 * n + 1]) << 8);
  }
};
inline std::optional<Data> parse_data(std::span<const std::byte> p) {
  if (p.size() < 4 || p.size() % 2 != 0) return std::nullopt;
  const Data d{read<std::uint16_t>(p, 0), p.size() / 2 - 1, p.subspan(2)};
  return d.offset + d.entries <= kMaxEntries ? std::optional(d) : std::nullopt;
}
/// A u16 or u32, by its size.
inline std::optional<std::uint32_t> parse_number(std::span<const std::byte> p) {
  if (p.size() == 2) return read<std::uint16_t>(p, 0);
  if (p.size() == 4) return read<std::uint32_t>(p, 0);
  return std::nullopt;
}

}  // namespace firn::drivers::fvb
