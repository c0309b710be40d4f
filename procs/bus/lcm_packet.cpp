#include "procs/bus/lcm_packet.h"

#include <algorithm>

namespace firn {
namespace {

constexpr std::uint32_t kShortMagic = 0x4c433032;     // "LC02"
constexpr std::uint32_t kFragmentMagic = 0x4c433033;  // "LC03"

void put_big_endian(std::uint32_t v, std::byte* to) {
  for (int k = 0; k < 4; ++k) to[k] = std::byte(v >> (24 - 8 * k));
}

std::uint32_t big_endian(const std::byte* from) {
  std::uint32_t v = 0;
  for (int k = 0; k < 4; ++k) v = v << 8 | std::uint32_t(from[k]);
  return v;
}

}  // namespace

const char* word(PacketFault fault) {
  switch (fault) {
    case PacketFault::kNone:
      return "none";
    case PacketFault::kShort:
      return "too short";
    case PacketFault::kFragment:
      return "a fragment";
    case PacketFault::kForeign:
      return "not LCM";
    case PacketFault::kChannel:
      return "no channel";
    case PacketFault::kTooLong:
      return "too long";
    case PacketFault::kNotLoopback:
      return "not by loopback";
    case PacketFault::kForged:
      return "without the key of the run";
    case PacketFault::kRepeated:
      return "repeated";
  }
  return "";
}

LcmPacket read_packet(std::span<const std::byte> datagram) {
  LcmPacket p;
  const auto refuse = [&](PacketFault fault) {
    p.fault = fault;
    return p;
  };
  if (datagram.size() < kPacketHead + 2) return refuse(PacketFault::kShort);
  const std::uint32_t magic = big_endian(datagram.data());
  if (magic == kFragmentMagic) return refuse(PacketFault::kFragment);
  if (magic != kShortMagic) return refuse(PacketFault::kForeign);
  const auto rest = datagram.subspan(kPacketHead);
  if (rest.size() > kMaxShortMessageBytes) return refuse(PacketFault::kTooLong);
  const auto name = rest.first(std::min(rest.size(), kMaxChannelBytes + 1));
  const auto end = std::ranges::find(name, std::byte{0});
  if (end == name.end() || end == name.begin()) return refuse(PacketFault::kChannel);
  const std::size_t length = std::size_t(end - name.begin());
  p.channel = {reinterpret_cast<const char*>(rest.data()), length};
  p.payload = rest.subspan(length + 1);
  return p;
}

void write_packet_head(std::uint32_t sequence, std::span<std::byte, kPacketHead> to) {
  put_big_endian(kShortMagic, to.data());
  put_big_endian(sequence, to.data() + 4);
}

}  // namespace firn
