// Bytes from the bus are not trusted: whatever they are, transport names and drops them and goes on.
#include <catch2/catch.hpp>

#include "firn/control_surface_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/heater_command_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/height_profile_t.hpp"
#include "firn/jet_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/laser_command_t.hpp"
#include "firn/laser_samples_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/resend_request_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/scan_done_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/tile_t.hpp"
#include "firn/valve_command_t.hpp"
#include "runtime/jump_check.h"
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
  tile_t t{};
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
    resend_request_t request{};
    request.header.run_id = kRun;
    request.header.seq = 1;
    request.n = 1;
    request.channel = {"ANSWER_STAGE"};
    request.from_seq = {1};
    request.to_seq = {std::int64_t(1) << 50};
    seeds.emplace_back(std::size_t(request.getEncodedSize()));
    request.encode(seeds[0].data(), 0, int(seeds[0].size()));
    heartbeat_t beat{};
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

namespace {

template <class Message>
Bytes encoded(Message m, std::int64_t seq, std::int32_t incarnation = 0) {
  m.header.run_id = kRun;
  m.header.incarnation = incarnation;
  m.header.seq = seq;
  Bytes out(std::size_t(m.getEncodedSize()));
  m.encode(out.data(), 0, int(out.size()));
  return out;
}

template <class Message>
Bytes with_epoch(std::int64_t epoch, std::int64_t seq, std::int32_t incarnation = 0) {
  Message m{};
  m.enable_epoch = epoch;
  return encoded(m, seq, incarnation);
}

Bytes map_of(std::int32_t layer, std::int64_t map_id, std::int64_t seq) {
  height_map_t m{};
  m.layer = layer;
  m.map_id = map_id;
  return encoded(m, seq);
}

/// Hears `channel` in `incarnation`.
struct Hearer {
  std::vector<Bytes> got;
  Transport transport;
  Hearer(std::string_view channel, std::int32_t incarnation = 0)
      : transport(
            [&] {
              TransportOptions o{NodeId::kRecorder, kRun};
              o.incarnation = incarnation;
              return o;
            }(),
            [this](const ChannelInfo&, std::span<const std::byte> b) {
              got.emplace_back(b.begin(), b.end());
            }) {
    transport.subscribe(channel);
  }
  bool takes(std::string_view channel, const Bytes& b) {
    const std::size_t before = got.size();
    transport.receive(channel, b, 0);
    return got.size() == before + 1 && got.back() == b;
  }
};

}  // namespace

TEST_CASE("no epoch is taken that safety cannot have reached, on any channel that carries one") {
  const auto check = [](std::string_view channel, auto make) {
    INFO(channel);
    for (std::int32_t incarnation = 0; incarnation < 4; ++incarnation) {
      Hearer h(channel, incarnation);
      const std::int64_t most = 2 * (incarnation + 1);
      for (const std::int64_t epoch : {most + 1, most + 100, std::int64_t(1) << 53, INT64_MAX})
        REQUIRE_FALSE(h.takes(channel, make(epoch, 1, incarnation)));
      REQUIRE(h.transport.stats().malformed == 4);
      for (std::int64_t epoch = 0; epoch <= most; ++epoch)  // and the refused ones have taken no place
        REQUIRE(h.takes(channel, make(epoch, epoch + 1, incarnation)));
    }
  };
  check("ENABLE", with_epoch<enable_t>);
  check("SAFE_STOP", with_epoch<safe_stop_t>);
  check("STAGE_COMMAND", with_epoch<stage_command_t>);
  check("JET_COMMAND", with_epoch<jet_command_t>);
  check("PROFILER_COMMAND", with_epoch<profiler_command_t>);
  check("LAMP_COMMAND", with_epoch<lamp_command_t>);
  check("ROBOT_COMMAND", with_epoch<robot_command_t>);
  check("VALVE_A_COMMAND", with_epoch<valve_command_t>);
  check("LASER_COMMAND", with_epoch<laser_command_t>);
  check("HEATER_COMMAND", with_epoch<heater_command_t>);
  for (const char* name : {"", "stage", "a long name of a driver"})
    check("STATE_STAGE", [name](std::int64_t epoch, std::int64_t seq, std::int32_t incarnation) {
      device_state_t m{};
      m.node = name;
      m.enable_epoch = epoch;
      return encoded(m, seq, incarnation);
    });
}

TEST_CASE("a refused epoch is named with its channel, value and limit") {
  Hearer h("SAFE_STOP", 1);
  h.takes("SAFE_STOP", with_epoch<safe_stop_t>(5, 1, 1));
  const auto notices = h.transport.take_notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0] == "SAFE_STOP: enable_epoch = 5 cannot follow, at most 4 can, dropped");
}

TEST_CASE(
    "no layer and no number of a scan or map far ahead is taken, and the true message takes its place") {
  const auto check = [](std::string_view channel, auto make) {
    INFO(channel);
    Hearer h(channel);
    RandomStream random(31, Purpose::kTest);
    std::int64_t layer = 0, number = 0;
    for (std::int64_t seq = 1; seq <= 300; ++seq) {
      const std::int64_t far = 1 + random.below(1'000'000);
      REQUIRE_FALSE(h.takes(channel, make(layer + kMaxLayersAtOnce + far, number, seq)));
      REQUIRE_FALSE(h.takes(channel, make(layer, number + kMaxScansAtOnce + far, seq)));
      layer += random.below(4) == 0 ? random.below(kMaxLayersAtOnce + 1) : random.below(2);
      number += 1 + (random.below(4) == 0 ? random.below(kMaxScansAtOnce) : 0);
      REQUIRE(h.takes(channel, make(layer, number, seq)));
    }
  };
  const auto maker = [](auto example, auto number) {
    return [example, number](std::int64_t layer, std::int64_t n, std::int64_t seq) {
      auto m = example;
      m.layer = std::int32_t(layer);
      m.*number = n;
      return encoded(m, seq);
    };
  };
  check("HEIGHT_MAP", maker(height_map_t{}, &height_map_t::map_id));
  check("LAYER_PLAN", maker(layer_plan_t{}, &layer_plan_t::map_id));
  check("CONTROL_SURFACE", maker(control_surface_t{}, &control_surface_t::map_id));
  check("HEIGHT_PROFILE", maker(height_profile_t{}, &height_profile_t::scan_id));
  check("LASER_SAMPLES", maker(laser_samples_t{}, &laser_samples_t::scan_id));
  check("SCAN_DONE", maker(scan_done_t{}, &scan_done_t::scan_id));
  check("DEPOSITION_REPORT", maker(deposition_report_t{}, &deposition_report_t::map_id));
  check("PATH_JOB", maker(path_job_t{}, &path_job_t::map_id));
  check("LAYER_METRICS", maker(layer_metrics_t{}, &layer_metrics_t::map_id));
}

TEST_CASE("no layer of a path's report far ahead is taken") {
  Hearer h("PATH_REPORT");
  path_report_t m{};
  m.layer = 1'000'000;
  CHECK_FALSE(h.takes("PATH_REPORT", encoded(m, 1)));
  m.layer = 100;
  CHECK(h.takes("PATH_REPORT", encoded(m, 1)));
}

TEST_CASE("a forged map that came too early is thrown away at its turn, and the true one is asked for") {
  Hearer h("HEIGHT_MAP");
  h.takes("HEIGHT_MAP", map_of(1'000'000, 2, 2));  // ahead of message 1
  CHECK(h.takes("HEIGHT_MAP", map_of(0, 1, 1)));
  h.transport.tick(1'000'000);
  Transport::Datagram d;
  REQUIRE(h.transport.next_datagram(1'000'000, d));
  CHECK(d.channel == "RESEND_RECORDER");
  CHECK(h.takes("HEIGHT_MAP", map_of(1, 2, 2)));
}

TEST_CASE("a number of a latest message far ahead does not shut out those that follow") {
  Hearer h("ENABLE");
  CHECK(h.takes("ENABLE", with_epoch<enable_t>(1, 1)));
  CHECK_FALSE(h.takes("ENABLE", with_epoch<enable_t>(1, std::int64_t(1) << 53)));
  CHECK(h.takes("ENABLE", with_epoch<enable_t>(1, 2)));
}

TEST_CASE("a resume names the message of an earlier start that no process of the run can have sent") {
  const auto resumed = [](std::string_view channel, const std::vector<Bytes>& before) {
    Hearer h(channel, 1);
    for (const Bytes& b : before) h.transport.restore_received(channel, b);
  };
  CHECK_NOTHROW(resumed("SAFE_STOP", {with_epoch<safe_stop_t>(2, 1)}));
  CHECK_THROWS_WITH(resumed("SAFE_STOP", {with_epoch<safe_stop_t>(1'000'000, 1)}),
                    Catch::Contains("SAFE_STOP, message 1") && Catch::Contains("enable_epoch = 1000000") &&
                        Catch::Contains("at most 2"));
  CHECK_THROWS_WITH(resumed("ENABLE", {with_epoch<enable_t>(1, 1, 7)}), Catch::Contains("incarnation 7"));
  CHECK_NOTHROW(resumed("HEIGHT_MAP", {map_of(400, 400, 400), map_of(401, 401, 401)}));  // the newest alone
  CHECK_THROWS_WITH(resumed("HEIGHT_MAP", {map_of(0, 1, 1), map_of(1'000'000, 2, 2)}),
                    Catch::Contains("HEIGHT_MAP, message 2") && Catch::Contains("layer = 1000000"));
}
