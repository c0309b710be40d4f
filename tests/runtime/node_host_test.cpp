#include <catch2/catch.hpp>

#include "firn/enable_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "runtime/device_guard.h"
#include "runtime/node_host.h"

namespace firn {
namespace {

// Keeps records in memory and remembers how many had been written when each handler ran.
struct MemorySink : WalSink {
  struct Entry {
    WalKind kind;
    std::vector<std::byte> payload;
  };
  void append(WalKind kind, std::span<const std::byte> payload) override {
    records.push_back({kind, {payload.begin(), payload.end()}});
  }
  void sync() override { ++syncs; }
  std::vector<Entry> records;
  int syncs = 0;
};

struct Probe : Node {
  Probe() {
    subscribe(channels::kRunEnd, this);
    subscribe(channels::kSafeStop, this);
  }
  void start(const Start& s, Time now, Outbox& out) override {
    incarnation = s.incarnation;
    out.wake_at(TimerId{1}, now.after_s(1.0));
    out.wake_at(TimerId{2}, now.after_s(0.5));
  }
  void wake(TimerId, Time, Outbox& out) override {
    if (sink) records_at_handler = sink->records.size();
    out.send(channels::kEnable, enable_t{});
    out.durable();
  }
  void on(const run_end_t& m, Time, Outbox&) { heard = m.reason; }
  void on(const safe_stop_t&, Time, Outbox& out) { out.send(channels::kLayerMetrics, layer_metrics_t{}); }
  const MemorySink* sink = nullptr;
  std::size_t records_at_handler = 0;
  std::string heard;
  int incarnation = -1;
};

Event start_event(std::int32_t incarnation = 0) {
  Event e;
  e.incarnation = incarnation;
  return e;
}
Event wake_event(std::uint32_t id, Time due) {
  Event e;
  e.kind = EventKind::kWake;
  e.id = id;
  e.due = e.now = due;
  return e;
}
template <class M>
std::vector<std::byte> encoded(M m) {
  m.header.run_id = 1;
  m.header.seq = 1;
  std::vector<std::byte> b(std::size_t(m.getEncodedSize()));
  m.encode(b.data(), 0, int(b.size()));
  return b;
}

safe_stop_t epoch_one() {
  safe_stop_t m{};
  m.enable_epoch = 1;
  return m;
}

TEST_CASE(
    "an event stands in the write-ahead file before its handler runs, its outputs before they are returned") {
  MemorySink sink;
  auto node = std::make_unique<Probe>();
  Probe* probe = node.get();
  probe->sink = &sink;
  NodeHost host(NodeId::kSafety, std::move(node), 1, &sink);
  host.step(start_event());
  const std::size_t before = sink.records.size();
  host.step(wake_event(2, Time{500000}));
  REQUIRE(probe->records_at_handler == before + 1);
  REQUIRE(sink.records.size() == before + 2);
  REQUIRE(sink.records.back().kind == WalKind::kOutputs);
  REQUIRE(sink.syncs == 1);  // the node asked for it
}

TEST_CASE("the timer that is due first comes first, and an armed timer is known by its time") {
  NodeHost host(NodeId::kSafety, std::make_unique<Probe>(), 1, nullptr);
  host.step(start_event());
  REQUIRE(host.next_timer()->timer == TimerId{2});
  REQUIRE(host.is_armed(TimerId{1}, Time{1000000}));
  REQUIRE_FALSE(host.is_armed(TimerId{1}, Time{999999}));
  host.step(wake_event(2, Time{500000}));
  REQUIRE(host.next_timer()->timer == TimerId{1});
}

TEST_CASE("a new incarnation keeps the node's memory and forgets its timers") {
  auto node = std::make_unique<Probe>();
  Probe* probe = node.get();
  NodeHost host(NodeId::kSafety, std::move(node), 1, nullptr);
  host.step(start_event());
  host.step(wake_event(2, Time{500000}));
  host.step(start_event(1));
  REQUIRE(probe->incarnation == 1);
  REQUIRE(host.is_armed(TimerId{2}, Time{500000}));
  // The sequence goes on through the resume.
  const Outbox& out = host.step(wake_event(2, Time{500000}));
  enable_t m{};
  m.decode(out.at(0).bytes.data(), 0, int(out.at(0).bytes.size()));
  REQUIRE(m.header.seq == 2);
  REQUIRE(m.header.incarnation == 1);
}

TEST_CASE("a message that does not decode becomes a fault of the node, and the handler does not run") {
  auto node = std::make_unique<Probe>();
  Probe* probe = node.get();
  NodeHost host(NodeId::kSafety, std::move(node), 1, nullptr);
  run_end_t m{};
  m.reason = "done";
  auto bytes = encoded(m);
  Event e;
  e.kind = EventKind::kMessage;
  e.channel = "RUN_END";
  e.bytes = bytes;
  host.step(e);
  REQUIRE(probe->heard == "done");
  probe->heard.clear();
  bytes.pop_back();
  e.bytes = bytes;
  const Outbox& out = host.step(e);
  REQUIRE(probe->heard.empty());
  REQUIRE(out.size() == 1);
  REQUIRE(out.at(0).channel == "FAULT_SAFETY");
  fault_t f{};
  f.decode(out.at(0).bytes.data(), 0, int(out.at(0).bytes.size()));
  REQUIRE(f.text.find("RUN_END") != std::string::npos);
}

TEST_CASE("a node cannot publish on a channel of another node") {
  NodeHost host(NodeId::kSafety, std::make_unique<Probe>(), 1, nullptr);
  const auto bytes = encoded(epoch_one());
  Event e;
  e.kind = EventKind::kMessage;
  e.channel = "SAFE_STOP";
  e.bytes = bytes;
  REQUIRE_THROWS_WITH(host.step(e), Catch::Contains("LAYER_METRICS") && Catch::Contains("scheduler"));
}

TEST_CASE("a node that subscribes to the simulated world's truth is refused") {
  struct Cheat : Node {
    Cheat() { subscribe(Channel<run_end_t>{"SIM_TRUTH"}, this); }
    void on(const run_end_t&, Time, Outbox&) {}
  };
  REQUIRE_THROWS_WITH(NodeHost(NodeId::kController, std::make_unique<Cheat>(), 1, nullptr),
                      Catch::Contains("SIM_TRUTH"));
}

TEST_CASE("replaying a step gives the bytes of the step") {
  NodeHost live(NodeId::kSafety, std::make_unique<Probe>(), 1, nullptr),
      again(NodeId::kSafety, std::make_unique<Probe>(), 1, nullptr);
  const Event events[] = {start_event(), wake_event(2, Time{500000}), wake_event(1, Time{1000000}),
                          start_event(1)};
  for (const Event& e : events) {
    std::vector<std::byte> a, b;
    encode_output_list(live.step(e), a);
    encode_output_list(again.replay_step(e), b);
    REQUIRE(a == b);
  }
}

TEST_CASE("a driver's lease runs out, and an older epoch is refused for ever") {
  DeviceGuard g;
  REQUIRE_FALSE(g.command_refusal(0, Time{0}).empty());
  g.enable(1, true, 0.3, Time{0}, Time{0});
  REQUIRE(g.command_refusal(1, Time{300000}).empty());
  REQUIRE(g.command_refusal(1, Time{300001}).find("lease") != std::string::npos);
  g.enable(1, true, 0.3, Time{400000}, Time{400000});
  REQUIRE(g.command_refusal(1, Time{500000}).empty());
  REQUIRE(g.safe_stop(2));
  REQUIRE_FALSE(g.safe_stop(2));
  g.enable(1, true, 0.3, Time{600000}, Time{600000});  // a late lease of the old epoch
  REQUIRE_FALSE(g.allowed(Time{600000}));
  REQUIRE(g.command_refusal(1, Time{600000}).find("older") != std::string::npos);
  g.enable(3, true, 0.3, Time{700000}, Time{700000});
  REQUIRE(g.command_refusal(3, Time{700000}).empty());
  g.local_stop();
  g.enable(3, true, 0.3, Time{700001}, Time{700001});
  REQUIRE_FALSE(g.command_refusal(3, Time{700001}).empty());
}

TEST_CASE(
    "a lease counts from the stamp of its sender, however late it is delivered, and never from the future") {
  DeviceGuard g;
  g.enable(1, true, 0.3, Time{100'000}, Time{350'000});  // a quarter of a second in a queue
  REQUIRE(g.allowed(Time{400'000}));
  REQUIRE_FALSE(g.allowed(Time{400'001}));
  g.enable(1, true, 0.3, Time{100'000}, Time{900'000});
  REQUIRE_FALSE(g.allowed(Time{900'000}));
  g.enable(1, true, 0.3, Time{5'000'000}, Time{1'000'000});
  REQUIRE(g.allowed(Time{1'300'000}));
  REQUIRE_FALSE(g.allowed(Time{1'300'001}));
}

TEST_CASE("what was allowed is lost with the lease, with a newer stop that waits, and with the enabling") {
  DeviceGuard g;
  g.enable(2, true, 0.3, Time{0}, Time{0});
  REQUIRE(g.lease_refusal(Time{300'000}, 0).empty());
  REQUIRE(g.lease_refusal(Time{300'001}, 0).find("ended") != std::string::npos);
  REQUIRE(g.lease_refusal(Time{1'000}, 2).empty());  // the stop of this epoch is handled already
  REQUIRE(g.lease_refusal(Time{1'000}, 3).find("SAFE_STOP of epoch 3") != std::string::npos);
  g.safe_stop(3);
  REQUIRE_FALSE(g.lease_refusal(Time{1'000}, 0).empty());
}

}  // namespace
}  // namespace firn
