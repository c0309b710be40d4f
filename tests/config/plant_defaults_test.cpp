// Ties the defaults of [plant] to those of the simulated world's own parameters.
#include <any>
#include <catch2/catch.hpp>

#include "config/include.h"
#include "plant/config/world_config.h"
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

TEST_CASE("The lab of the measured droplet prints with its shape, and with its heights as means over cells") {
  const Experiment e = load_experiment(FIRN_SOURCE_DIR "/labs/inkjet-droplet413.toml");
  plant::DropletParams wanted = plant::droplet413();
  CHECK(plant::world_config(e).droplet == wanted);
  wanted.slope_bias_mm = 0.003;
  const Experiment steep =
      load_experiment(FIRN_SOURCE_DIR "/labs/inkjet-droplet413.toml", {"plant.slope_bias_mm=0.003"});
  CHECK(plant::world_config(steep).droplet == wanted);
  // A full layer is as high as with the other droplet.
  CHECK(e.model.h1_mm + 4 * e.model.h2_mm + 4 * e.model.h3_mm == Approx(0.0076).epsilon(1e-6));
}
