// Keys of laws of nature and of instruments' faults: whose they are, and that they reach the world.
#include <catch2/catch.hpp>

#include "config/checks.h"
#include "config/error.h"
#include "config/fields.h"
#include "plant/inkjet/model.h"
#include "plant/world/setup.h"

using namespace firn;

namespace {

Experiment with_keys(const std::string& text) { return parse_experiment(text, "n.toml"); }

std::string refusal_with(const std::string& text) {
  try {
    with_keys(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

std::string of_model(std::string_view name) { return "plant.model = \"" + std::string(name) + "\"\n"; }

}  // namespace

TEST_CASE("Every word of plant.model makes a world, and no other word does") {
  for (const plant::NatureName& n : plant::kNatureNames) {
    const Experiment e = with_keys(of_model(n.name));
    CHECK(plant::make_model(plant::world_config(e)) != nullptr);
  }
  CHECK_THAT(refusal_with(of_model("foam")), Catch::Contains("must be one of droplets, lu2015"));
}

TEST_CASE("A key of one law of nature is refused with another, by the law's name") {
  CHECK_THAT(refusal_with("plant.wu_chiu.cover = 0.5\n"),
             Catch::Contains("n.toml:1") && Catch::Contains("is of plant.model = \"wu_chiu\""));
  CHECK_THAT(refusal_with(of_model("lu2015") + "plant.thin_film.wet_s = 2.0\n"),
             Catch::Contains("is of plant.model = \"thin_film\""));
  CHECK(refusal_with(of_model("thin_film") + "plant.thin_film.wet_s = 2.0\n").empty());
}

TEST_CASE("A dump has the keys of its own law of nature, and reads back to itself") {
  for (const plant::NatureName& n : plant::kNatureNames) {
    const std::string text = dump(with_keys(of_model(n.name)));
    CHECK(dump(with_keys(text)) == text);
    for (const char* section : {"wu_chiu", "graph_flow", "thin_film"})
      CHECK((text.find("[plant." + std::string(section) + "]") != std::string::npos) == (n.name == section));
  }
}

TEST_CASE("Faults of instruments and parameters of nature reach the world as they are written") {
  const plant::WorldConfig c = plant::world_config(
      with_keys(of_model("wu_chiu") +
                "plant.wu_chiu.cover = 0.33\nplant.wu_chiu.order = \"pass\"\nplant.sensor.tilt = 0.002\n"
                "plant.sensor.spot_x_mm = 0.07\nplant.nozzle.dead_layer = 7\nplant.stage.backlash_mm = 0.03\n"
                "plant.sensor_noise_mm = 0.004\n"));
  CHECK(c.nature.wu_chiu.cover == 0.33);
  CHECK(c.nature.wu_chiu.order == plant::FlowOrder::kPass);
  CHECK(c.sensor.tilt == 0.002);
  CHECK(c.sensor.spot_x_mm == 0.07);
  CHECK(c.sensor.noise_mm == 0.004);
  CHECK(c.nozzle_faults.dead_layer == 7);
  CHECK(c.stage_faults.backlash_mm == 0.03);
}

TEST_CASE("A world without faults is the world that it was before there were any") {
  const plant::WorldConfig c = plant::world_config(with_keys(""));
  CHECK(static_cast<const plant::SensorOptions&>(c.sensor) == plant::SensorOptions{});
  CHECK(!c.nozzle_faults.any());
  CHECK(!c.stage_faults.any());
}

TEST_CASE("Laws of nature with one ink, or with nothing between cells, refuse what needs more") {
  const std::string block =
      "part.shape = \"cuboid\"\npart.width_mm = 4.0\npart.depth_mm = 4.0\npart.height_mm = 0.1\n"
      "geometry.shape = \"ellipsoid\"\n";
  CHECK_THAT(refusal_with(of_model("graph_flow") + block), Catch::Contains("prints one ink"));
  for (const char* name : {"lu2015", "wu_chiu", "graph_flow"})
    CHECK_THAT(refusal_with(of_model(name) + "actuation.offsets = \"x\"\n"),
               Catch::Contains("plant.model = \"" + std::string(name) + "\" has nothing between cells"));
  CHECK(refusal_with(of_model("thin_film") + "actuation.offsets = \"x\"\n").empty());
}
