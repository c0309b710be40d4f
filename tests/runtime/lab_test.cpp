#include <catch2/catch.hpp>

#include "firn/enable_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/safe_stop_t.hpp"

#include "runtime/lab.h"

namespace firn {
namespace {

enable_t lease() {
  enable_t m{};
  m.header.run_id = 1;
  m.header.seq = 1;
  m.enable_epoch = 1;
  m.lease_s = 0.3;
  return m;
}

// Sends ENABLE every 10 ms and finishes after ten.
struct Ticker : Node {
  void start(const Start&, Time now, Outbox& out) override { out.wake_at(TimerId{1}, now.after_s(0.01)); }
  void wake(TimerId, Time now, Outbox& out) override {
    out.send(channels::kEnable, lease());
    if (++count == 10) return out.finish(0, "ten");
    out.wake_at(TimerId{1}, now.after_s(0.01));
  }
  int count = 0;
};

struct Listener : Node {
  Listener() { subscribe(channels::kEnable, this); }
  void on(const enable_t& m, Time now, Outbox&) {
    times.push_back(now);
    seqs.push_back(m.header.seq);
  }
  std::vector<Time> times;
  std::vector<std::int64_t> seqs;
};

// Echoes a driver's bytes, 3 ms later.
struct EchoWorld : LabWorld {
  void connect(std::string_view, Time) override { ++connects; }
  void disconnect(std::string_view, Time) override {}
  void receive(std::string_view port, std::span<const std::byte> bytes, Time now) override {
    pending.push_back({std::string(port), {bytes.begin(), bytes.end()}, now.after_s(0.003)});
  }
  Time next_event() const override { return pending.empty() ? Time::never() : pending.front().at; }
  void advance(Time now, const Send& send) override {
    while (!pending.empty() && pending.front().at <= now) {
      send(pending.front().port, pending.front().bytes, pending.front().at, false);
      pending.erase(pending.begin());
    }
  }
  struct Item {
    std::string port;
    std::vector<std::byte> bytes;
    Time at;
  };
  std::vector<Item> pending;
  int connects = 0;
};

struct Driver : Node {
  std::vector<std::string> ports() const override { return {"jet"}; }
  void on_link(PortId p, LinkState s, Time, Outbox& out) override {
    if (s == LinkState::kOpen) out.write(p, std::as_bytes(std::span("ping", 4)));
  }
  void on_io(PortId, std::span<const std::byte> bytes, Time now, Outbox& out) override {
    got.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    at = now;
    out.finish(0, "pong");
  }
  std::string got;
  Time at;
};

TEST_CASE("the Lab delivers messages in simulated time, in order, without waiting") {
  Lab lab(nullptr);
  auto listener_node = std::make_unique<Listener>();
  Listener* listener = listener_node.get();
  NodeHost ticker(NodeId::kSafety, std::make_unique<Ticker>(), 1, nullptr);
  NodeHost listening(NodeId::kStage, std::move(listener_node), 1, nullptr);
  lab.add(&ticker);
  lab.add(&listening);
  lab.start(0, Time{0});
  const NodeId wait[] = {NodeId::kSafety};
  REQUIRE(lab.run(wait, Time{}.after_s(10)) == Lab::End::kFinished);
  while (lab.step(lab.now())) {
  }
  REQUIRE(listener->seqs.size() == 10);
  for (int n = 0; n < 10; ++n) {
    REQUIRE(listener->seqs[std::size_t(n)] == n + 1);
    REQUIRE(listener->times[std::size_t(n)] == Time{10000 * (n + 1)});
  }
}

TEST_CASE("the Lab stops at its time limit and says so") {
  Lab lab(nullptr);
  NodeHost ticker(NodeId::kSafety, std::make_unique<Ticker>(), 1, nullptr);
  lab.add(&ticker);
  lab.start(0, Time{0});
  const NodeId wait[] = {NodeId::kSafety};
  REQUIRE(lab.run(wait, Time{55000}) == Lab::End::kTimeLimit);
  REQUIRE(lab.now() == Time{55000});
}

TEST_CASE("a driver's bytes reach the world and come back at the world's time") {
  EchoWorld world;
  Lab lab(&world);
  auto node = std::make_unique<Driver>();
  Driver* driver = node.get();
  NodeHost host(NodeId::kJet, std::move(node), 1, nullptr);
  lab.add(&host);
  lab.start(0, Time{1000});
  const NodeId wait[] = {NodeId::kJet};
  REQUIRE(lab.run(wait, Time{}.after_s(1)) == Lab::End::kFinished);
  REQUIRE(world.connects == 1);
  REQUIRE(driver->got == "ping");
  REQUIRE(driver->at == Time{4000});
}

TEST_CASE("a port that a node reopens at its start is told open once") {
  struct Reopener : Driver {
    void start(const Start&, Time, Outbox& out) override { out.reopen(PortId{0}); }
    void on_link(PortId p, LinkState s, Time now, Outbox& out) override {
      ++told;
      Driver::on_link(p, s, now, out);
    }
    int told = 0;
  };
  EchoWorld world;
  Lab lab(&world);
  auto node = std::make_unique<Reopener>();
  Reopener* driver = node.get();
  NodeHost host(NodeId::kJet, std::move(node), 1, nullptr);
  lab.add(&host);
  lab.start(1, Time{1000});
  const NodeId wait[] = {NodeId::kJet};
  REQUIRE(lab.run(wait, Time{}.after_s(1)) == Lab::End::kFinished);
  CHECK(world.connects == 1);
  CHECK(driver->told == 1);
}

TEST_CASE("a message handed to one node reaches no other") {
  Lab lab(nullptr);
  auto a_node = std::make_unique<Listener>(), b_node = std::make_unique<Listener>();
  Listener *a = a_node.get(), *b = b_node.get();
  NodeHost first(NodeId::kStage, std::move(a_node), 1, nullptr),
      second(NodeId::kJet, std::move(b_node), 1, nullptr);
  lab.add(&first);
  lab.add(&second);
  const enable_t m = lease();
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  lab.publish_to(NodeId::kJet, "ENABLE", bytes);
  while (lab.step(Time{}.after_s(1))) {
  }
  REQUIRE(a->seqs.empty());
  REQUIRE(b->seqs.size() == 1);
}

}  // namespace
}  // namespace firn
