// Ties the defaults of [plant] to those of the simulated world's own parameters.
#include <any>
#include <catch2/catch.hpp>

#include "plant/world/aerosol_lab.h"
#include "plant/world/setup.h"

using namespace firn;

TEST_CASE("Nature's own defaults are those of the configuration") {
  Experiment e;
  const plant::WorldConfig inkjet = plant::world_config(e);
  CHECK(inkjet.droplet == plant::DropletParams{});
  CHECK(inkjet.nozzle == plant::NozzleParams{});
  CHECK(inkjet.lu2015 == plant::Lu2015Params{});
  CHECK(inkjet.sensor == plant::SensorParams{});
  CHECK(inkjet.strobe == plant::StrobeParams{});
  e.lab.kind = "aerosol";
  CHECK(std::any_cast<plant::AerosolWorldConfig>(plant::world_config(e).own).nozzle ==
        plant::AerosolParams{});
  e.lab.kind = "ice";
  const plant::IceWorldConfig ice = plant::world_config(e).ice, own;
  CHECK(ice.line == own.line);
  CHECK(ice.arm == own.arm);
  CHECK(ice.laser == own.laser);
  CHECK(ice.table == own.table);
  CHECK(ice.disturbance == own.disturbance);
  CHECK(ice.balance == own.balance);
}
