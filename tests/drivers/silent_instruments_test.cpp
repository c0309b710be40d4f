// Instruments that fall silent while nobody waits for an answer: each driver asks at rest, and says so.
#include <catch2/catch.hpp>

#include <string>

#include "tests/drivers/ice_rig.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::IceRig;
using firn::drivers::test::PortRig;
using firn::drivers::test::WorldRig;
using plant::FaultKind;

namespace {

constexpr double kRest_s = 20.0, kNoticed_s = 12.0, kBack_s = 120.0;

void check_silence(PortRig& rig, const std::string& port) {
  for (const FaultKind kind : {FaultKind::kHang, FaultKind::kHalfOpen}) {
    CAPTURE(port, plant::fault_name(kind));
    rig.run_for(kRest_s);
    REQUIRE(rig.driver(port).safe());
    const auto told = [&] { return rig.all<Fault>(port).size(); };
    const std::size_t before = told();
    rig.world.inject({port, kind, 1, 0}, rig.now_us);
    CHECK(rig.run([&] { return told() > before || !rig.driver(port).safe(); }, kNoticed_s));
    if (kind == FaultKind::kHang) rig.world.inject({port, FaultKind::kResume, 1, 0}, rig.now_us);
    REQUIRE(rig.run([&] { return rig.driver(port).safe(); }, kBack_s));
  }
}

}  // namespace

TEST_CASE(
    "each instrument of the ink-jet lab that falls silent at rest is noticed within 12 s, and used again",
    "[I2]") {
  for (const char* port : {"stage", "jet", "laser_profiler", "lamp"}) {
    WorldRig rig(WorldRig::small_world(6, 4));
    rig.start();
    check_silence(rig, port);
  }
}

TEST_CASE("each instrument of the ice lab that falls silent at rest is noticed within 12 s, and used again",
          "[I2]") {
  for (const char* port : {"robot", "valve_a", "valve_b", "laser_point", "heater"}) {
    IceRig rig;
    rig.start();
    check_silence(rig, port);
  }
}
