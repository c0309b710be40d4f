// Numbers of a layer-wise record that no sample has.
#include "files/layer_record.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "files/usage_error.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;

namespace {
LayerRecord read(const std::string& rows, const LayerRecordOptions& options = {}) {
  return read_layer_table("layer,x_mm,y_mm,height_mm,drops\n" + rows, "r.csv", options);
}
}  // namespace

TEST_CASE("A position or height further than a kilometre from the origin is refused by line and name") {
  CHECK_THROWS_WITH(read("1,0,0,5,1\n2,0.5,6e45,1,1\n"),
                    "r.csv:3: y = 6e+45 mm, not within 1e+06 mm of the origin");
  CHECK_THROWS_WITH(read("1,inf,0,5,1\n"), Contains("r.csv:2: x_mm = inf: is not a finite number"));
  CHECK_THROWS_WITH(read("1,0,0,1e308,1\n1,0,0,-1e308,1\n"), Contains("r.csv:2: height = 1e+308 mm"));
  CHECK(read("1,1000000,0,5,1\n").points == 1);
}

TEST_CASE("A pitch that makes more cells than a grid holds is refused with their number") {
  LayerRecordOptions fine;
  fine.pitch_x_mm = 1e-300;
  CHECK_THROWS_WITH(read("1,0,0,5,1\n1,1,0,5,1\n", fine), Contains("r.csv: 1e+300 cells along x"));
}

TEST_CASE("An infinite input is refused by line, a missing one is taken") {
  CHECK_THROWS_WITH(read("1,0,0,5,inf\n"), "r.csv:2: drops = inf: is not a finite number");
  CHECK(std::isnan(read("1,0,0,5,nan\n").inputs[0].cells[0]));
}

TEST_CASE("A matrix file with an infinite or far number is refused with its folder, layer and limit") {
  const test::TempFolder folder;
  folder.file("maps/layer-0.csv", "0,0\n");
  folder.file("maps/layer-1.csv", "1,2\n");
  folder.file("inputs/layer-1.csv", "1,2\n");
  const auto heights = folder.path() / "maps", inputs = folder.path() / "inputs";
  CHECK(read_layer_files({.heights = heights, .inputs = inputs}, {}).heights[1].cells[1] == 2.0);
  folder.file("inputs/layer-1.csv", "1,-inf\n");
  CHECK_THROWS_WITH(read_layer_files({.heights = heights, .inputs = inputs}, {}),
                    Contains("layer-1.csv:1: column 2 = -inf: is not a finite number"));
  folder.file("inputs/layer-1.csv", "1,2\n");
  folder.file("maps/layer-1.csv", "1,2e7\n");
  CHECK_THROWS_WITH(read_layer_files({.heights = heights, .inputs = inputs}, {}),
                    Contains("maps: layer 1: a height [mm] of 2e+07, not within 1e+06"));
}
