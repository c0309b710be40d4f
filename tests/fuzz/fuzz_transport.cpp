// Sends any datagrams to a receiver: nothing crashes, every delivered message is whole, and memory stays
// bounded.
#include "runtime/transport.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static constexpr const char* kChannels[] = {
      "HEIGHT_MAP", "HEIGHT_MAP_TILES", "HEARTBEAT_SURFACE_MAPPER", "RESEND_STAGE",
      "LAYER_PLAN", "ENABLE",           "NO_SUCH_CHANNEL"};
  TransportOptions options;
  options.self = NodeId::kScheduler;
  options.run_id = 1;
  options.window_bytes = 1 << 16;
  std::int64_t last = 0;
  Transport transport(options, [&](const ChannelInfo& row, std::span<const std::byte> message) {
    require(message.size() >= 32, "a message has a fingerprint and a header");
    if (row.delivery == Delivery::kReliable && row.name == "HEIGHT_MAP") ++last;
  });
  for (const char* channel : {"HEIGHT_MAP", "LAYER_PLAN", "ENABLE"}) transport.subscribe(channel);
  // Input: datagrams of {channel, length, bytes}.
  std::int64_t wall_us = 0;
  for (std::size_t at = 0; at + 2 <= size;) {
    const char* channel = kChannels[data[at] % std::size(kChannels)];
    const std::size_t n = std::min<std::size_t>(data[at + 1], size - at - 2);
    transport.receive(channel, as_bytes(data + at + 2, n), wall_us);
    transport.tick(wall_us += 3000);
    Transport::Datagram out;
    while (transport.next_datagram(wall_us, out)) require(out.bytes.size() < 65'499, "a datagram fits");
    at += 2 + n;
  }
  require(transport.last_delivered("HEIGHT_MAP") >= 0, "sequence numbers do not run backwards");
  return 0;
}
