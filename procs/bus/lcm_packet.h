// LcmPacket is one datagram of LCM's UDP multicast protocol: a short message with its channel and payload.
// Longer messages are fragments in LCM; Firn sends none (its transport cuts messages into tiles before) and
// takes none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace firn {

inline constexpr std::size_t kMaxChannelBytes = 63;          ///< of a channel's name, without its NUL
inline constexpr std::size_t kMaxShortMessageBytes = 65499;  ///< channel, NUL and payload

/// Why a datagram is no message for Firn.
enum class PacketFault : std::uint8_t {
  kNone,
  kShort,        ///< less than a header and an empty channel
  kFragment,     ///< a piece of a long message
  kForeign,      ///< not LCM
  kChannel,      ///< its channel is empty, longer than 63 bytes, or has no end
  kTooLong,      ///< longer than a datagram of LCM
  kNotLoopback,  ///< arrived by another interface, or from another host
  kForged,       ///< without a MAC under the run's key, or altered
  kRepeated,     ///< authenticated, and taken before
};
inline constexpr int kPacketFaults = 9;
const char* word(PacketFault fault);

struct LcmPacket {
  PacketFault fault = PacketFault::kNone;
  std::string_view channel;            ///< views into the datagram
  std::span<const std::byte> payload;  ///< may be empty
};

/// Never reads beyond the datagram, whatever stands in it.
LcmPacket read_packet(std::span<const std::byte> datagram);

/// Size of a short message's head: magic number, sequence number.
inline constexpr std::size_t kPacketHead = 8;
void write_packet_head(std::uint32_t sequence, std::span<std::byte, kPacketHead> to);

}  // namespace firn
