// The functions of transport_wire read datagrams with bounds on everything, without decoding whole messages.
// LCM encodes big endian; every message starts with its fingerprint (8 bytes) and header_t. Bytes from the
// bus are not trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace firn::wire {

inline constexpr std::size_t kLargestWholeBytes = 60'000;  ///< larger messages go as tiles
inline constexpr std::size_t kTileDataBytes =
    59'904;  ///< of a full tile; with its 56 bytes of head below 60,000
inline constexpr std::size_t kLargestObjectBytes = std::size_t(64) << 20;
inline constexpr std::size_t kHeaderEnd = 36;  ///< fingerprint and header_t
inline constexpr std::string_view kTilesSuffix = "_TILES";

struct Header {
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::int64_t seq = 0;
  std::int64_t utime_us = 0;
};
/// Nothing if the bytes are too short or a number cannot be (negative incarnation, seq < 1).
std::optional<Header> read_header(std::span<const std::byte> message);

struct Tile {
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::int64_t seq = 0;
  std::int32_t index = 0;
  std::int32_t count = 0;
  std::int64_t total_bytes = 0;
  std::uint64_t checksum = 0;
  std::span<const std::byte> data;
};
/// Nothing unless size, index, count and total_bytes fit each other and kLargestObjectBytes.
std::optional<Tile> read_tile(std::span<const std::byte> datagram);
std::vector<std::byte> encode_tile(const Tile& tile);
std::int32_t tile_count(std::size_t total_bytes);

struct LastSeq {
  std::string_view channel;
  std::int64_t seq = 0;
};
/// The last sequence numbers in a heartbeat_t; nothing if it is malformed.
std::optional<std::vector<LastSeq>> read_heartbeat(std::span<const std::byte> message);

struct SeqRange {
  std::string_view channel;
  std::int64_t from = 0, to = 0;  ///< both included
};
/// The ranges of a resend_request_t; nothing if it is malformed.
std::optional<std::vector<SeqRange>> read_resend_request(std::span<const std::byte> message);
std::vector<std::byte> encode_resend_request(const Header& header, std::string_view node,
                                             std::span<const SeqRange> ranges);

}  // namespace firn::wire
