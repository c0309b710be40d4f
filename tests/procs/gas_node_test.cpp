// The gas node against its twin: commands, readings as messages, the lease, the stop, the death of its
// process.
#include <catch2/catch.hpp>

#include "firn/enable_t.hpp"
#include "firn/fault_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "plant/twins/gas.h"
#include "procs/gas/node.h"
#include "tests/support/node_bench.h"

namespace firn::test {
namespace {

struct NoGasWires : plant::Wires {
  void pulse(int, std::int64_t, const double[3], const double[3]) override {}
  void softtrigger(std::int64_t, plant::Port, int) override {}
  void lamp(std::int64_t, plant::LampEvent, double) override {}
  void link_closed(std::int64_t, plant::Port) override {}
  void note(std::int64_t, plant::Port, plant::DeviceEvent, std::int64_t) override {}
};

struct GasLab : NodeBench {
  GasLab()
      : NodeBench(NodeId::kGas, std::make_unique<GasNode>(Experiment{})), twin(plant::Port::kGas, {}, wires) {
    start();
    open();
  }
  void open() {
    link(0, LinkState::kOpen);
    twin.link().connect(now.us);
    run_until([this] { return state() == DeviceState::kSafe; });
  }
  void lease() {
    enable_t m{};
    m.enable_epoch = epoch;
    m.enabled = 1;
    m.lease_s = 0.3;
    give(channels::kEnable, m);
  }
  DeviceState state() const {
    const auto states = all(channels::device_state(NodeId::kGas));
    return states.empty() ? DeviceState::kDisconnected : DeviceState(states.back().state);
  }
  template <class Done>
  void run_until(Done&& done, double within_s = 30.0) {
    const std::int64_t end_us = now.us + std::int64_t(within_s * 1e6);
    while (now.us < end_us && !done()) {
      const std::vector<std::byte> bytes = std::exchange(written, {});
      if (!bytes.empty()) twin.take(bytes, now.us);
      now.us += 1000;
      if (leased && now.us % 50'000 == 0) lease();
      for (auto timer = host.next_timer(); timer && timer->at <= now; timer = host.next_timer()) wake();
      while (twin.link().next_send_us() <= now.us) {
        const std::string said = twin.link().pop_send().bytes;
        io(0, std::as_bytes(std::span(said.data(), said.size())));
      }
    }
    REQUIRE(done());
  }
  void run_for(double s) {
    const std::int64_t end_us = now.us + std::int64_t(s * 1e6);
    run_until([&] { return now.us >= end_us; }, s + 1.0);
  }
  answer_t set(double atomizer, double sheath, std::int64_t of_epoch = 1) {
    const std::size_t before = all(channels::answer(NodeId::kGas)).size();
    gas_command_t c{};
    c.command_id = ++command;
    c.enable_epoch = of_epoch;
    c.verb = std::int8_t(GasVerb::kSet);
    c.atomizer_sccm = atomizer;
    c.sheath_sccm = sheath;
    give(channels::kGasCommand, c);
    run_until([&] { return all(channels::answer(NodeId::kGas)).size() > before; });
    return last(channels::answer(NodeId::kGas));
  }

  NoGasWires wires;
  plant::GasTwin twin;
  std::int64_t command = 0, epoch = 1;
  bool leased = true;
};

}  // namespace

TEST_CASE("The gas node answers done when both flows are there, and its readings become messages") {
  GasLab lab;
  const answer_t a = lab.set(20.0, 40.0);
  INFO(a.text);
  REQUIRE(Outcome(a.outcome) == Outcome::kDone);
  CHECK(lab.twin.sccm(0, lab.now.us) == Approx(20.0).epsilon(0.06));
  CHECK(lab.twin.sccm(1, lab.now.us) == Approx(40.0).epsilon(0.06));
  const std::size_t before = lab.all(channels::kGasFlow).size();
  lab.run_for(10.0);
  const auto flows = lab.all(channels::kGasFlow);
  CHECK(flows.size() - before >= 25);
  CHECK(flows.size() - before <= 41);
  const gas_flow_t& m = flows.back();
  CHECK(m.steady == 1);
  CHECK(m.sccm[0] == Approx(20.0).margin(0.2));
  CHECK(m.set_sccm[1] == 40.0);
  CHECK(m.pressure_kPa[1] == Approx(lab.twin.nozzle_kpa(lab.now.us)).margin(0.1));
  CHECK(int(m.fault[0]) == 0);
}

TEST_CASE("A gas command of an older epoch, beyond a cap or without a sheath is refused and sends nothing") {
  GasLab lab;
  lab.epoch = 2;
  lab.run_for(0.1);
  for (const auto& [atomizer, sheath, epoch, why] : {std::tuple{20.0, 40.0, std::int64_t(1), "epoch"},
                                                     {101.0, 40.0, std::int64_t(2), "outside"},
                                                     {20.0, 0.0, std::int64_t(2), "without a sheath"}}) {
    const answer_t a = lab.set(atomizer, sheath, epoch);
    CHECK(Outcome(a.outcome) == Outcome::kRefused);
    CHECK_THAT(a.text, Catch::Contains(why));
    lab.run_for(2.0);
    CHECK(lab.twin.sccm(0, lab.now.us) == 0.0);
    CHECK(lab.twin.sccm(1, lab.now.us) == 0.0);
  }
}

TEST_CASE("A safe stop, a lost lease and a local stop end the ink's gas and leave the sheath's", "[I16]") {
  for (const int way : {0, 1, 2}) {
    CAPTURE(way);
    GasLab lab;
    REQUIRE(Outcome(lab.set(20.0, 40.0).outcome) == Outcome::kDone);
    REQUIRE(lab.state() == DeviceState::kActive);
    lab.leased = false;
    if (way == 0) {
      safe_stop_t stop{};
      stop.enable_epoch = 2;
      stop.cause = "test";
      lab.give(channels::kSafeStop, stop);
    }
    if (way == 2) lab.local_stop("test");
    lab.run_until([&] { return lab.state() == DeviceState::kSafe; }, 8.0);
    lab.run_for(3.0);
    CHECK(lab.twin.sccm(0, lab.now.us) < 0.1);
    CHECK(lab.twin.sccm(1, lab.now.us) == Approx(40.0).margin(0.5));
  }
}

TEST_CASE("A gas node that comes back ends the ink's gas that its death had left on") {
  GasLab lab;
  REQUIRE(Outcome(lab.set(20.0, 40.0).outcome) == Outcome::kDone);
  lab.start(1);
  lab.run_for(2.0);
  CHECK(lab.twin.sccm(0, lab.now.us) == Approx(20.0).margin(0.5));  // the controllers go on by themselves
  lab.open();
  lab.run_for(3.0);
  CHECK(lab.twin.sccm(0, lab.now.us) < 0.1);
}

}  // namespace firn::test
