#include <catch2/catch.hpp>

#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/safe_stop_t.hpp"
#include "procs/safety/node.h"
#include "tests/support/node_bench.h"

namespace firn {
namespace {

constexpr NodeId kDrivers[] = {NodeId::kStage, NodeId::kJet, NodeId::kLaserProfiler, NodeId::kLamp};

Experiment lab(bool two_jets) {
  Experiment e;
  if (two_jets) e.control.scheme = "registration";
  return e;
}

struct SafetyBench : test::NodeBench {
  explicit SafetyBench(bool two_jets = false)
      : NodeBench(NodeId::kSafety, std::make_unique<Safety>(lab(two_jets))) {
    start();
  }
  void state(NodeId driver, DeviceState state, std::int64_t epoch) {
    device_state_t m{};
    m.node = info(driver).name;
    m.state = std::int8_t(state);
    m.enable_epoch = epoch;
    give(channels::device_state(driver), m);
  }
  void all_safe(std::int64_t epoch) {
    for (NodeId d : kDrivers) state(d, DeviceState::kSafe, epoch);
  }
  void fault(int severity) {
    fault_t f{};
    f.severity = std::int8_t(severity);
    f.node = "jet";
    f.text = "nozzle blocked";
    give(channels::fault(NodeId::kJet), f);
  }
  enable_t lease() { return last(channels::kEnable); }
};

TEST_CASE("safety grants no lease before every driver has answered SAFE") {
  SafetyBench b;
  for (std::size_t n = 0; n + 1 < std::size(kDrivers); ++n) {
    b.state(kDrivers[n], DeviceState::kSafe, 0);
    b.wake();
    REQUIRE_FALSE(b.lease().enabled);
  }
  b.state(kDrivers[3], DeviceState::kIdentifying, 0);
  REQUIRE_FALSE(b.lease().enabled);
  b.state(kDrivers[3], DeviceState::kSafe, 0);
  REQUIRE(b.lease().enabled);
}

TEST_CASE("with two jets the lease waits for both, and ends when both are armed", "[I-]") {
  SafetyBench b(true);
  b.all_safe(0);
  b.wake();
  REQUIRE_FALSE(b.lease().enabled);
  b.state(NodeId::kJetB, DeviceState::kSafe, 0);
  REQUIRE(b.lease().enabled);
  b.state(NodeId::kJet, DeviceState::kArmed, 0);
  REQUIRE(b.all(channels::kSafeStop).empty());
  b.state(NodeId::kJetB, DeviceState::kArmed, 0);
  REQUIRE(b.all(channels::kSafeStop).size() == 1);
  REQUIRE(b.last(channels::kSafeStop).cause.find("both jets are armed") != std::string::npos);
}

TEST_CASE("safety renews the lease at least three times while it lasts") {
  SafetyBench b;
  b.all_safe(0);
  const Time from = b.now;
  const std::size_t before = b.all(channels::kEnable).size();
  while (seconds_between(from, b.now) < b.lease().lease_s) b.wake();
  REQUIRE(b.all(channels::kEnable).size() - before >= 3);
}

TEST_CASE("a fault of severity 2 raises the epoch, names its cause and ends the lease for good") {
  SafetyBench b;
  b.all_safe(0);
  const std::int64_t before = b.lease().enable_epoch;
  const std::size_t leases = b.all(channels::kEnable).size();
  b.fault(2);
  REQUIRE(b.last(channels::kSafeStop).enable_epoch == before + 1);
  REQUIRE(b.last(channels::kSafeStop).cause == "jet: nozzle blocked");
  for (int n = 0; n < 20; ++n) b.wake();
  REQUIRE(b.all(channels::kEnable).size() == leases);
}

TEST_CASE("a warning does not stop the print") {
  SafetyBench b;
  b.all_safe(0);
  b.fault(1);
  REQUIRE(b.all(channels::kSafeStop).empty());
  REQUIRE(b.lease().enabled);
}

TEST_CASE("SAFE_STOP is repeated until every driver honours the new epoch, and not longer") {
  SafetyBench b;
  b.all_safe(0);
  b.fault(2);
  const std::int64_t epoch = b.last(channels::kSafeStop).enable_epoch;
  b.all_safe(epoch - 1);  // still the old epoch
  const std::size_t before = b.all(channels::kSafeStop).size();
  b.wake();
  b.wake();
  REQUIRE(b.all(channels::kSafeStop).size() == before + 2);
  REQUIRE_FALSE(b.host.finished());
  b.all_safe(epoch);
  REQUIRE(b.host.finished() == 3);
  REQUIRE(b.host.finish_reason() == "jet: nozzle blocked");
  REQUIRE_FALSE([&] {
    b.wake();
    return b.wake();
  }());
}

TEST_CASE("a heartbeat that stops is a safe stop that names the node", "[I4]") {
  SafetyBench b;
  b.all_safe(0);
  heartbeat_t h{};
  h.node = "lamp";
  b.give(channels::heartbeat(NodeId::kLamp), h);
  for (int n = 0; n < 9; ++n) b.wake();
  REQUIRE(b.all(channels::kSafeStop).empty());
  for (int n = 0; n < 3; ++n) b.wake();
  REQUIRE(b.last(channels::kSafeStop).cause.find("lamp") != std::string::npos);
}

TEST_CASE("a step that takes longer than the node's table allows is a safe stop") {
  SafetyBench b;
  b.all_safe(0);
  heartbeat_t h{};
  h.node = "stage";
  h.busy_since_us = 1;
  for (int n = 0; n < 60 && b.all(channels::kSafeStop).empty(); ++n) {
    b.give(channels::heartbeat(NodeId::kStage), h);
    b.wake();
  }
  REQUIRE(b.last(channels::kSafeStop).cause.find("stage has been busy") != std::string::npos);
  REQUIRE(b.now.s() == Approx(info(NodeId::kStage).longest_step_s).margin(0.2));
}

TEST_CASE("a resume begins with a newer epoch than anything commanded before it") {
  SafetyBench b;
  b.all_safe(0);
  b.fault(2);
  const std::int64_t stopped = b.last(channels::kSafeStop).enable_epoch;
  b.all_safe(stopped);
  b.start(1);
  REQUIRE(b.lease().enable_epoch > stopped);
  REQUIRE_FALSE(b.lease().enabled);
  b.all_safe(stopped);
  REQUIRE(b.lease().enabled);
}

TEST_CASE("the end of the run ends the lease") {
  SafetyBench b;
  b.all_safe(0);
  b.give(channels::kRunEnd, run_end_t{});
  REQUIRE_FALSE(b.lease().enabled);
  REQUIRE(b.host.finished() == 0);
}

TEST_CASE("a local stop stops all drivers, not only this process") {
  SafetyBench b;
  b.all_safe(0);
  b.local_stop("the launcher is gone");
  REQUIRE(b.last(channels::kSafeStop).cause == "the launcher is gone");
}

}  // namespace
}  // namespace firn
