// Any bytes as a datagram from the network: a message whose channel and payload lie in it, or a named fault.
#include "procs/bus/lcm_packet.h"

#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto datagram = as_bytes(data, size);
  const LcmPacket p = read_packet(datagram);
  require(*word(p.fault) != 0, "each fault has a word");
  if (p.fault != PacketFault::kNone) {
    require(p.channel.empty() && p.payload.empty(), "what is no message hands nothing on");
    return 0;
  }
  require(!p.channel.empty() && p.channel.size() <= kMaxChannelBytes, "a channel has 1 to 63 bytes");
  require(lies_in(std::as_bytes(std::span(p.channel)), datagram) && lies_in(p.payload, datagram),
          "channel and payload lie in the datagram");
  require(kPacketHead + p.channel.size() + 1 + p.payload.size() == size, "a message fills its datagram");
  return 0;
}
