// Bytes from the bus are not trusted: whatever they are, transport names and drops them and goes on.
#include <catch2/catch.hpp>

#include "firn/resend_request_t.hpp"
#include "firn/tile_t.hpp"
#include "runtime/transport_wire.h"
#include "tests/runtime/transport_net.h"

using namespace firn;
using namespace firn::test;

namespace {

struct Receiver {
  std::vector<Bytes> got;
  Transport transport{{NodeId::kStage, kRun}, [this](const ChannelInfo&, std::span<const std::byte> b) {
                        got.emplace_back(b.begin(), b.end());
                      }};
  Receiver() { transport.subscribe("STAGE_COMMAND"); }
  bool noticed(const std::string& text) {
    for (const std::string& n : transport.take_notices())
      if (n.find(text) != std::string::npos) return true;
    return false;
  }
};

Bytes tile(std::int32_t index, std::int32_t count, std::int64_t total, std::size_t data,
           std::int64_t seq = 1) {
  const Bytes body(data);
  return wire::encode_tile({kRun, 0, seq, index, count, total, 0, body});
}

}  // namespace

TEST_CASE("our tiles are the bytes that LCM's own encoder makes of tile_t") {
  RandomStream random(1, Purpose::kTest);
  const Bytes body = message(1, 1000, random);
  tile_t t;
  t.size = std::int32_t(body.size());
  t.run_id = 3;
  t.incarnation = 1;
  t.seq = 9;
  t.index = 2;
  t.count = 4;
  t.total_bytes = 200'000;
  t.checksum = std::int64_t(0xF123456789ABCDEFull);
  for (const std::byte b : body) t.data.push_back(std::uint8_t(b));
  Bytes expected(std::size_t(t.getEncodedSize()));
  t.encode(expected.data(), 0, int(expected.size()));
  CHECK(wire::encode_tile({3, 1, 9, 2, 4, 200'000, 0xF123456789ABCDEFull, body}) == expected);
}

TEST_CASE("another run's messages are dropped, counted and named once") {
  RandomStream random(2, Purpose::kTest);
  Receiver r;
  for (std::int64_t seq = 1; seq <= 5; ++seq)
    r.transport.receive("STAGE_COMMAND", message(seq, 10, random, 0, 12), 0);
  CHECK(r.got.empty());
  CHECK(r.transport.stats().foreign == 5);
  const auto notices = r.transport.take_notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0].find("messages of run 12 on the port of run 77") != std::string::npos);
}

TEST_CASE("an incarnation never goes back, and one that is yet to come is foreign") {
  RandomStream random(3, Purpose::kTest);
  std::vector<Bytes> got;
  TransportOptions o{NodeId::kStage, kRun};
  o.incarnation = 2;
  Transport t(
      o, [&](const ChannelInfo&, std::span<const std::byte> b) { got.emplace_back(b.begin(), b.end()); });
  t.subscribe("STAGE_COMMAND");
  t.receive("STAGE_COMMAND", message(1, 10, random, 0), 0);
  t.receive("STAGE_COMMAND", message(2, 10, random, 2), 0);
  t.receive("STAGE_COMMAND", message(3, 10, random, 1), 0);
  t.receive("STAGE_COMMAND", message(3, 10, random, 3), 0);
  CHECK(got.size() == 2);
  CHECK(t.stats().malformed == 1);
  CHECK(t.stats().foreign == 1);
}

TEST_CASE("tiles with wrong lengths, indices or sizes are named and dropped") {
  Receiver r;
  const std::int64_t two = std::int64_t(wire::kTileDataBytes) + 10;
  const std::vector<Bytes> bad{
      tile(2, 2, two, 10),  // index beyond the end
      tile(-1, 2, two, 10),
      tile(0, 3, two, wire::kTileDataBytes),  // count that does not fit the total
      tile(1, 2, two, 11),                    // too much data
      tile(1, 2, two, 9),                     // too little
      tile(0, 1, 0, 0),
      tile(0, 2, std::int64_t(1) << 62, wire::kTileDataBytes),
      tile(0, 1200, std::int64_t(wire::kLargestObjectBytes) + 1, wire::kTileDataBytes),
      tile(0, 2, -two, wire::kTileDataBytes),
      tile(0, 2, two, wire::kTileDataBytes, -4),
      Bytes(56),
      Bytes(3),
      {}};
  for (const Bytes& b : bad) r.transport.receive("STAGE_COMMAND_TILES", b, 0);
  CHECK(r.transport.stats().malformed == bad.size());
  CHECK(r.noticed("STAGE_COMMAND: a tile whose numbers do not fit"));
  CHECK_FALSE(r.transport.waiting());
}

TEST_CASE("tiles that disagree or do not give what was announced do not block the true message") {
  RandomStream random(4, Purpose::kTest);
  const Bytes truth = message(1, 100'000, random);
  Transport sender({NodeId::kScheduler, kRun}, [](const ChannelInfo&, std::span<const std::byte>) {});
  Receiver r;
  r.transport.receive("STAGE_COMMAND_TILES", tile(0, 2, 100'036, wire::kTileDataBytes), 0);  // other checksum
  r.transport.receive("STAGE_COMMAND_TILES", tile(0, 1, 50'000, 50'000), 0);  // complete, but not a message
  sender.send("STAGE_COMMAND", truth, 0);
  Transport::Datagram d;
  for (std::int64_t now = 0; now < 1000; ++now)
    while (sender.next_datagram(now, d)) r.transport.receive(d.channel, d.bytes, now);
  REQUIRE(r.got.size() == 1);
  CHECK(r.got[0] == truth);
  CHECK(r.transport.stats().malformed >= 2);
}

TEST_CASE("a sequence number far ahead is no reason to wait or to allocate") {
  RandomStream random(5, Purpose::kTest);
  Receiver r;
  r.transport.receive("STAGE_COMMAND", message(std::int64_t(1) << 60, 10, random), 0);
  r.transport.receive("STAGE_COMMAND_TILES", tile(0, 2, 100'000, wire::kTileDataBytes, std::int64_t(1) << 40),
                      0);
  CHECK_FALSE(r.transport.waiting());
  CHECK(r.noticed("STAGE_COMMAND: a sequence number far ahead"));
  r.transport.receive("STAGE_COMMAND", message(1, 10, random), 0);
  CHECK(r.got.size() == 1);
}

TEST_CASE("a claim of messages that do not exist is forgotten at the publisher's next heartbeat") {
  RandomStream random(6, Purpose::kTest);
  Net net({}, {});
  Peer& scheduler = net.add(NodeId::kScheduler, {});
  Peer& stage = net.add(NodeId::kStage, {"STAGE_COMMAND"});
  net.send(scheduler, "STAGE_COMMAND", message(1, 10, random));
  net.run(1000);
  stage.transport->receive("STAGE_COMMAND_TILES", tile(0, 2, 100'000, wire::kTileDataBytes, 4000),
                           net.now_us);
  CHECK(stage.transport->waiting());
  net.run(300'000);
  CHECK_FALSE(stage.transport->waiting());
  CHECK(stage.got["STAGE_COMMAND"].size() == 1);
}

TEST_CASE("any bit flipped, any cut, any noise: no crash, and the stream goes on") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    RandomStream random(seed, Purpose::kTest, 9);
    Net net({}, {});
    Peer& scheduler = net.add(NodeId::kScheduler, {});
    Peer& stage = net.add(NodeId::kStage, {"STAGE_COMMAND"});
    const auto wire = stage.transport->wire_channels();
    std::vector<Bytes> seeds;
    resend_request_t request;
    request.header.run_id = kRun;
    request.header.seq = 1;
    request.n = 1;
    request.channel = {"ANSWER_STAGE"};
    request.from_seq = {1};
    request.to_seq = {std::int64_t(1) << 50};
    seeds.emplace_back(std::size_t(request.getEncodedSize()));
    request.encode(seeds[0].data(), 0, int(seeds[0].size()));
    heartbeat_t beat;
    beat.header = request.header;
    beat.n = 1;
    beat.channel = {"STAGE_COMMAND"};
    beat.last_seq = {3};
    seeds.emplace_back(std::size_t(beat.getEncodedSize()));
    beat.encode(seeds[1].data(), 0, int(seeds[1].size()));
    seeds.push_back(tile(0, 1, 200, 200, 2));
    seeds.push_back(message(1, 60, random, 0, kRun + 1));
    for (int n = 0; n < 4000; ++n) {
      Bytes b = seeds[random.below(4)];
      for (std::uint32_t flips = random.below(4); flips > 0; --flips)
        b[random.below(std::uint32_t(b.size()))] ^= std::byte(1u << random.below(8));
      if (random.below(3) == 0) b.resize(random.below(std::uint32_t(b.size())));
      // Noise that is a sound message of this run is a message: here it stands on channels that are not
      // compared.
      const std::string& channel = wire[random.below(std::uint32_t(wire.size()))];
      if (channel == "STAGE_COMMAND") continue;
      stage.transport->receive(channel, b, net.now_us);
    }
    for (std::int64_t seq = 1; seq <= 20; ++seq)
      net.send(scheduler, "STAGE_COMMAND", message(seq, 5000 * seq, random));
    net.run(2'000'000);
    CHECK(stage.got["STAGE_COMMAND"] == scheduler.sent["STAGE_COMMAND"]);
    CHECK(stage.transport->stats().malformed > 100);
    CHECK(stage.transport->take_notices().size() <= 64);
  }
}
