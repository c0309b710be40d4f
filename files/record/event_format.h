// plausible_event and put_event_header read and write the header of one event of an LCM log, big endian: u32
// sync word, i64 eventnum, i64 utime, i32 channel length, i32 data length, channel, data.
// https://lcm-proj.github.io/lcm/content/log-file-format.html
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace firn::record {

inline constexpr std::uint32_t kEventSync = 0xEDA1DA01u;
inline constexpr std::array<unsigned char, 4> kEventSyncBytes{0xED, 0xA1, 0xDA, 0x01};
inline constexpr std::size_t kEventHeaderBytes = 28;
inline constexpr std::int32_t kMaxEventChannelBytes = 999;  // the limit of LCM's own reader

inline std::uint32_t big32(const std::byte* p) {
  std::uint32_t v;
  std::memcpy(&v, p, 4);
  return __builtin_bswap32(v);
}
inline std::uint64_t big64(const std::byte* p) {
  std::uint64_t v;
  std::memcpy(&v, p, 8);
  return __builtin_bswap64(v);
}
inline void put_big32(std::byte* p, std::uint32_t v) {
  v = __builtin_bswap32(v);
  std::memcpy(p, &v, 4);
}
inline void put_big64(std::byte* p, std::uint64_t v) {
  v = __builtin_bswap64(v);
  std::memcpy(p, &v, 8);
}

struct EventHeader {
  std::uint64_t at = 0;  ///< offset in the file
  std::uint64_t eventnum = 0;
  std::int64_t utime_us = 0;
  std::int32_t channel_bytes = 0;
  std::int32_t data_bytes = 0;

  std::uint64_t bytes() const {
    return kEventHeaderBytes + std::uint64_t(channel_bytes) + std::uint64_t(data_bytes);
  }
  std::uint64_t end() const { return at + bytes(); }
};

inline void put_event_header(std::byte* p, const EventHeader& h) {
  put_big32(p, kEventSync);
  put_big64(p + 4, h.eventnum);
  put_big64(p + 12, std::uint64_t(h.utime_us));
  put_big32(p + 20, std::uint32_t(h.channel_bytes));
  put_big32(p + 24, std::uint32_t(h.data_bytes));
}

inline std::string_view event_channel(std::span<const std::byte> log, const EventHeader& h) {
  return {reinterpret_cast<const char*>(log.data() + h.at + kEventHeaderBytes), std::size_t(h.channel_bytes)};
}

inline bool plausible_channel(std::string_view name) {
  for (const unsigned char c : name)
    if (c < 0x20 || c == 0x7f) return false;
  return !name.empty() && name.size() <= std::size_t(kMaxEventChannelBytes);
}

/// Fills `h` from the bytes at `at`. @returns false unless a whole event could be there: sync word, lengths
/// within the file, a channel of printable characters, a number that an event counter can reach.
inline bool plausible_event(std::span<const std::byte> log, std::uint64_t at, EventHeader& h) {
  if (at > log.size() || log.size() - at < kEventHeaderBytes + 1) return false;
  const std::byte* p = log.data() + at;
  h = {at, big64(p + 4), std::int64_t(big64(p + 12)), std::int32_t(big32(p + 20)),
       std::int32_t(big32(p + 24))};
  return big32(p) == kEventSync && h.channel_bytes > 0 && h.channel_bytes <= kMaxEventChannelBytes &&
         h.data_bytes >= 0 && h.bytes() <= log.size() - at && h.eventnum >> 56 == 0 &&
         plausible_channel(event_channel(log, h));
}

}  // namespace firn::record
