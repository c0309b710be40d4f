#include "drivers/thermometer/thermometer.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "plant/world/ice_lab.h"
#include "procs/thermometer/node.h"
#include "tests/drivers/port_rig.h"

using namespace firn;
using namespace firn::drivers;

namespace {

struct Rig : drivers::test::PortRig {
  Rig() : PortRig(ice_world()), thermometer(ThermometerOptions{}) {
    add("thermometer", thermometer);
    connect_all();
  }
  void trip(std::int64_t code) {
    plant::SimFault f;
    f.port = "thermometer";
    f.kind = plant::FaultKind::kTrip;
    f.count = code;
    world.inject(f, now_us);
  }
  double newest() const { return all<BedTemperature>("thermometer").back().celsius; }

  Thermometer thermometer;

 private:
  static plant::WorldConfig ice_world() {
    plant::WorldConfig c;
    c.kind = &plant::kIceWorld;
    return c;
  }
};

}  // namespace

TEST_CASE("a line is a temperature, an open probe, or damaged") {
  CHECK(*parse_bed_temperature("-3.50") == -3.5);
  CHECK(std::isnan(*parse_bed_temperature("OPEN")));
  for (const char* damaged : {"", "23.4x", "1e9", "nan", "T?"}) CHECK_FALSE(parse_bed_temperature(damaged));
}

TEST_CASE("the driver reads once a second what its twin shows, and goes on after a lost link") {
  Rig rig;
  rig.run_for(10.0);
  CHECK(rig.all<BedTemperature>("thermometer").size() >= 10);
  CHECK(std::abs(rig.newest() - rig.world.ice()->ice_truth().heat.section_degC[0]) < 0.5);
  rig.trip(1);
  rig.run_for(2.0);
  CHECK(std::isnan(rig.newest()));
  rig.trip(0);
  rig.kill("thermometer");
  rig.resume("thermometer");
  rig.run_for(2.0);
  CHECK(rig.thermometer.safe());
  CHECK(std::isfinite(rig.newest()));
}

TEST_CASE("the node is built from a configuration and has the instrument's port") {
  const auto node = make_thermometer(
      "[lab]\nkind = \"ice\"\n[control]\nscheme = \"open_loop\"\n[ice]\nmesh = \"part.stl\"\n"
      "slice = \"slice.toml\"\nmachine = \"machine.toml\"\n"
      "[thermometer]\npoll_s = 0.5\n", {});
  CHECK(node->ports() == std::vector<std::string>{"thermometer"});
}
