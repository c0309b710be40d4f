#include "procs/bus/channel_filter.h"

#include <array>
#include <cstdint>
#include <string_view>

#include "procs/bus/lcm_packet.h"

namespace firn {
namespace {

constexpr unsigned kUdpHead = 8;  // bytes that the kernel shows before the datagram
constexpr unsigned kName = kUdpHead + kPacketHead;
constexpr std::uint32_t kPass = 0xFFFFFFFF, kDrop = 0;
static_assert(kShortestFiltered == kPacketHead + kMaxChannelBytes + 1);

sock_filter load(int size, unsigned offset) {
  return BPF_STMT(std::uint16_t(BPF_LD | BPF_ABS | size), offset);
}
sock_filter jump(int test, std::uint32_t value, unsigned if_true, unsigned if_false) {
  return BPF_JUMP(std::uint16_t(BPF_JMP | BPF_K | test), value, std::uint8_t(if_true),
                  std::uint8_t(if_false));
}
sock_filter verdict(std::uint32_t bytes) { return BPF_STMT(BPF_RET | BPF_K, bytes); }

/// Passes a datagram whose channel begins with these bytes, and goes on behind for any other.
void add_start(std::vector<sock_filter>& program, std::string_view start) {
  const std::size_t size = start.size();
  const auto byte = [&](std::size_t n) { return std::uint32_t(std::uint8_t(start[n])); };
  std::vector<sock_filter> compared;
  std::vector<std::size_t> jumps;
  const auto compare = [&](int load_size, std::size_t at, std::uint32_t value) {
    compared.push_back(load(load_size, kName + unsigned(at)));
    jumps.push_back(compared.size());
    compared.push_back(jump(BPF_JEQ, value, 0, 0));
  };
  std::size_t n = 0;
  for (; n + 4 <= size; n += 4)
    compare(BPF_W, n, byte(n) << 24 | byte(n + 1) << 16 | byte(n + 2) << 8 | byte(n + 3));
  for (; n < size; ++n) compare(BPF_B, n, byte(n));
  compared.push_back(verdict(kPass));
  for (const std::size_t at : jumps) compared[at].jf = std::uint8_t(compared.size() - at - 1);
  program.insert(program.end(), compared.begin(), compared.end());
}

}  // namespace

std::vector<sock_filter> channel_filter(const std::set<std::string, std::less<>>& channels,
                                        const std::string& prefix) {
  std::array<std::byte, kPacketHead> head{};
  write_packet_head(0, head);
  std::uint32_t magic = 0;
  for (int n = 0; n < 4; ++n) magic = magic << 8 | std::uint32_t(head[std::size_t(n)]);
  std::vector<sock_filter> program{
      BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0),
      jump(BPF_JGE, kUdpHead + kShortestFiltered, 1, 0),
      verdict(kPass),
      load(BPF_W, kUdpHead),
      jump(BPF_JEQ, magic, 1, 0),
      verdict(kPass),
      load(BPF_B, kName),
      jump(BPF_JEQ, 0, 0, 1),  // an empty channel
      verdict(kPass),
  };
  for (const std::string& channel : channels)
    add_start(program, std::string_view(channel.c_str(), channel.size() + 1));  // with the NUL behind it
  if (!prefix.empty()) add_start(program, prefix);
  // None of them. A channel that has an end is another one.
  for (unsigned n = 1; n <= kMaxChannelBytes; ++n) {
    program.push_back(load(BPF_B, kName + n));
    program.push_back(jump(BPF_JEQ, 0, 2 * (kMaxChannelBytes - n) + 1, 0));
  }
  program.push_back(verdict(kPass));
  program.push_back(verdict(kDrop));
  return program.size() <= BPF_MAXINSNS ? program : std::vector<sock_filter>{};
}

}  // namespace firn
