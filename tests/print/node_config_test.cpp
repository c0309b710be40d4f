// Nodes are handed the configuration without the simulated truth.
#include <catch2/catch.hpp>

#include "config/experiment.h"
#include "config/fields.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"

using namespace firn;

TEST_CASE("No node is handed a key of the plant, in any lab") {
  for (const PrintLab* lab : full_product().labs) {
    const std::string config = dump(lab->fullest());
    REQUIRE_THAT(config, Catch::Contains("[plant]"));
    CHECK_THAT(without_plant(config), !Catch::Contains("plant"));
  }
}

TEST_CASE("All other keys reach the nodes unchanged") {
  for (const PrintLab* lab : full_product().labs) {
    Experiment e = lab->fullest();
    e.control.seed = 77;
    e.plant.seed = 99;
    const Experiment handed = parse_experiment(without_plant(dump(e)), "experiment.toml");
    CHECK(handed.plant.seed == PlantConfig{}.seed);
    e.plant = handed.plant;
    CHECK(dump(handed) == dump(e));
  }
}

namespace {

std::string handed_over;

std::unique_ptr<Node> keep_config(const std::string& config, const Blobs&) {
  handed_over = config;
  return nullptr;
}

}  // namespace

TEST_CASE("A maker of nodes hands over the stripped configuration, wherever it is called") {
  const MakeNode make = &keep_config;
  make("[run]\nname = \"a\"\n[plant]\nseed = 3\n[plant.ice]\ncell_mm = 0.2\n[bus]\nlease_s = 0.3\n", {});
  CHECK(handed_over == "[run]\nname = \"a\"\n[bus]\nlease_s = 0.3\n");
  make("plant.seed = 3\n[plantation]\nx = 1", {});
  CHECK(handed_over == "[plantation]\nx = 1");
}
