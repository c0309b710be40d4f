#include <catch2/catch.hpp>

#include <algorithm>

#include "runtime/transport_wire.h"
#include "tests/runtime/transport_net.h"

using namespace firn;
using namespace firn::test;

namespace {

constexpr std::size_t kSizes[] = {0,      1,      8,      200,     3000,    20'000,
                                  59'964, 60'000, 61'000, 119'000, 300'000, 700'000};

void finish(Net& net, std::int64_t limit_us = 60'000'000) {
  net.run(1'500'000);  // of the heartbeats after the last message, which tell of a lost tail, one arrives
  while (!net.idle() && net.now_us < limit_us) net.run(100'000);
}

}  // namespace

TEST_CASE("every reliable message arrives once, in order, byte for byte, whatever the network does") {
  std::uint64_t injected = 0, resent = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    LossyOptions faults{random.uniform(0.0, 0.3), random.uniform(0.0, 0.3),  random.uniform(0.0, 0.4),
                        random.uniform(0.0, 0.2), random.uniform(0.0, 0.05), seed};
    Net net(faults, {});
    const std::string commands = "STAGE_COMMAND", jets = "JET_COMMAND", maps = "HEIGHT_MAP",
                      answers = "ANSWER_STAGE";
    Peer& scheduler = net.add(NodeId::kScheduler, {answers, maps});
    Peer& stage = net.add(NodeId::kStage, {commands});
    Peer& mapper = net.add(NodeId::kSurfaceMapper, {});
    Peer& recorder = net.add(NodeId::kRecorder, {commands, jets, maps, answers});
    std::map<std::string, std::int64_t> seq;
    for (int n = 0; n < 150; ++n) {
      const auto pick = random.below(4);
      const std::string& channel = pick == 0 ? commands : pick == 1 ? jets : pick == 2 ? maps : answers;
      Peer& from = pick < 2 ? scheduler : pick == 2 ? mapper : stage;
      const std::size_t size = random.below(5) == 0 ? kSizes[random.below(12)] : random.below(2000);
      net.send(from, channel, message(++seq[channel], size, random));
      net.run(std::int64_t(random.below(3000)));
    }
    finish(net);
    INFO("seed " << seed << ", simulated " << net.now_us << " us");
    REQUIRE(net.idle());
    for (const std::string& c : {commands, jets}) CHECK(recorder.got[c] == scheduler.sent[c]);
    CHECK(recorder.got[maps] == mapper.sent[maps]);
    CHECK(recorder.got[answers] == stage.sent[answers]);
    CHECK(stage.got[commands] == scheduler.sent[commands]);
    CHECK(scheduler.got[maps] == mapper.sent[maps]);
    CHECK(scheduler.got[answers] == stage.sent[answers]);
    CHECK(net.injected() > 0);
    CHECK(net.largest <= 65'499);
    injected += net.injected();
    resent += scheduler.transport->stats().resent + stage.transport->stats().resent +
              mapper.transport->stats().resent;
  }
  CHECK(injected > 1000);
  CHECK(resent > 100);
}

TEST_CASE("a kill and a resume of either side lose, repeat and change nothing") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RandomStream random(seed, Purpose::kKill);
    TransportOptions small;
    small.ring_bytes = 40'000;  // so that much must come from the write-ahead file
    Net net({0.1, 0.1, 0.1, 0.1, 0.02, seed}, small);
    const std::string commands = "STAGE_COMMAND";
    Peer& scheduler = net.add(NodeId::kScheduler, {"ANSWER_STAGE"});
    Peer& stage = net.add(NodeId::kStage, {commands});
    std::int32_t incarnation = 0;
    std::int64_t seq = 0, answer = 0;
    for (int n = 0; n < 120; ++n) {
      net.send(scheduler, commands, message(++seq, random.below(4) == 0 ? 90'000 : 500, random, incarnation));
      if (random.below(2)) net.send(stage, "ANSWER_STAGE", message(++answer, 50, random, incarnation));
      net.run(std::int64_t(random.below(4000)));
      if (n % 40 == 39) {  // all processes of a run end and start together
        ++incarnation;
        net.restart(scheduler, incarnation);
        net.restart(stage, incarnation);
      }
    }
    finish(net);
    INFO("seed " << seed);
    REQUIRE(net.idle());
    CHECK(stage.got[commands] == scheduler.sent[commands]);
    CHECK(scheduler.got["ANSWER_STAGE"] == stage.sent["ANSWER_STAGE"]);
    CHECK(net.injected() > 0);
  }
}

TEST_CASE("a lost tail is noticed by the heartbeat alone") {
  RandomStream random(5, Purpose::kTest);
  Net net({}, {});
  Peer& scheduler = net.add(NodeId::kScheduler, {});
  Peer& stage = net.add(NodeId::kStage, {"STAGE_COMMAND"});
  for (std::int64_t seq = 1; seq <= 3; ++seq) {  // restored = sent, but no datagram of it ever left
    Bytes m = message(seq, 100, random);
    scheduler.transport->restore_sent("STAGE_COMMAND", m);
    scheduler.sent["STAGE_COMMAND"].push_back(m);
  }
  finish(net);
  CHECK(stage.got["STAGE_COMMAND"] == scheduler.sent["STAGE_COMMAND"]);
  CHECK(stage.transport->stats().missing == 3);
}

TEST_CASE("a process listens to the heartbeats of those alone whose reliable messages it takes") {
  Net net({}, {});
  const auto heartbeats = [&](NodeId node, const std::vector<std::string>& subscriptions) {
    std::vector<std::string> heard = net.add(node, subscriptions).transport->wire_channels();
    std::erase_if(heard, [](const std::string& name) { return !name.starts_with("HEARTBEAT_"); });
    return heard;
  };
  CHECK(heartbeats(NodeId::kStage, {"STAGE_COMMAND", "ENABLE"}) ==
        std::vector<std::string>{"HEARTBEAT_SCHEDULER"});
  CHECK(heartbeats(NodeId::kScheduler, {"ANSWER_STAGE", "STATE_STAGE", "ANSWER_JET"}) ==
        std::vector<std::string>{"HEARTBEAT_JET", "HEARTBEAT_STAGE"});
}

TEST_CASE("on a latest channel nothing goes back in time, and the newest arrives when nothing is lost") {
  RandomStream random(6, Purpose::kTest);
  Net net({0.2, 0.2, 0.3, 0.2, 0.01, 6}, {});
  Peer& safety = net.add(NodeId::kSafety, {});
  Peer& jet = net.add(NodeId::kJet, {"ENABLE"});
  for (std::int64_t seq = 1; seq <= 500; ++seq) {
    net.send(safety, "ENABLE", message(seq, 17, random));
    net.run(500);
  }
  net.run(100'000);
  const auto& got = jet.got["ENABLE"];
  const auto& sent = safety.sent["ENABLE"];
  REQUIRE(got.size() > 100);
  CHECK(got.size() < sent.size());
  auto from = sent.begin();
  for (const Bytes& m : got) {
    from = std::find(from, sent.end(), m);
    REQUIRE(from != sent.end());
    ++from;
  }
  CHECK(safety.transport->stats().resent == 0);
}

TEST_CASE("tiles leave no closer than the pace, and small messages overtake them") {
  RandomStream random(7, Purpose::kTest);
  Transport t({NodeId::kScheduler, kRun}, [](const ChannelInfo&, std::span<const std::byte>) {});
  t.send("STAGE_COMMAND", message(1, 400'000, random), 0);
  t.send("JET_COMMAND", message(1, 100, random), 0);
  Transport::Datagram d;
  REQUIRE(t.next_datagram(0, d));
  CHECK(d.channel == "JET_COMMAND");
  std::vector<std::int64_t> at;
  for (std::int64_t now = 0; now < 10'000; ++now)
    while (t.next_datagram(now, d)) at.push_back(now);
  REQUIRE(at.size() == 7);
  for (std::size_t n = 1; n < at.size(); ++n) CHECK(at[n] - at[n - 1] == 200);
  CHECK(t.backlog_bytes() == 0);
  CHECK(t.due_us(0) == std::numeric_limits<std::int64_t>::max());
}

TEST_CASE(
    "as many bytes as a receiver holds leave at once, what follows keeps the pace, and a pause lets as many "
    "again") {
  RandomStream random(8, Purpose::kTest);
  TransportOptions options{NodeId::kScheduler, kRun};
  options.burst_bytes = 4 * wire::kTileDataBytes;
  Transport t(options, [](const ChannelInfo&, std::span<const std::byte>) {});
  const auto times_of = [&](std::int64_t seq, std::int64_t from_us) {
    t.send("STAGE_COMMAND", message(seq, 10 * wire::kTileDataBytes - 36, random), from_us);
    std::vector<std::int64_t> at;
    Transport::Datagram d;
    for (std::int64_t now = from_us; now < from_us + 10'000; ++now)
      while (t.next_datagram(now, d)) at.push_back(now - from_us);
    return at;
  };
  const std::vector<std::int64_t> wanted{0, 0, 0, 0, 0, 200, 400, 600, 800, 1000};
  CHECK(times_of(1, 50'000) == wanted);
  CHECK(times_of(2, 100'000) == wanted);
}

TEST_CASE("requests are few: a dead publisher is asked with growing pauses") {
  RandomStream random(8, Purpose::kTest);
  Net net({}, {});
  Peer& stage = net.add(NodeId::kStage, {"STAGE_COMMAND"});
  stage.transport->receive("STAGE_COMMAND", message(5, 10, random), net.now_us);
  net.run(10'000'000);
  CHECK(stage.transport->waiting());
  CHECK(stage.transport->stats().requests > 10);
  CHECK(stage.transport->stats().requests < 60);
  CHECK(stage.got.empty());
}

TEST_CASE("a sender that skips a number or does not own the channel is a bug that is named") {
  RandomStream random(9, Purpose::kTest);
  Transport t({NodeId::kScheduler, kRun}, [](const ChannelInfo&, std::span<const std::byte>) {});
  CHECK_THROWS_WITH(t.send("STAGE_COMMAND", message(2, 10, random), 0),
                    Catch::Contains("STAGE_COMMAND: seq 2 after 0"));
  CHECK_THROWS_WITH(t.send("HEIGHT_MAP", message(1, 10, random), 0),
                    Catch::Contains("scheduler must not publish HEIGHT_MAP"));
  CHECK_THROWS_WITH(t.subscribe("HIGHT_MAP"), Catch::Contains("HIGHT_MAP"));
}
