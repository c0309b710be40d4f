// Layers in files of a matrix each: numbers in their names, and names around the matrix.
#include <catch2/catch.hpp>
#include <cmath>

#include "files/layer_record.h"
#include "files/usage_error.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;

namespace {

/// Layers with a height, of files with these names.
std::string layers_of(const std::vector<std::string>& names, int layer_number = 0) {
  const test::TempFolder folder;
  for (const std::string& name : names) folder.file("maps/" + name, "0.5,0.25\n");
  LayerRecordOptions options;
  options.layer_number = layer_number;
  try {
    const LayerRecord r = read_layer_files({.heights = folder.path() / "maps"}, options);
    std::string layers;
    for (std::size_t k = 1; k < r.heights.size(); ++k)
      if (!std::isnan(r.heights[k].cells[0])) layers += (layers.empty() ? "" : " ") + std::to_string(k);
    return layers;
  } catch (const UsageError& e) {
    return e.what();
  }
}

/// "3 x 2, 6 heights, sum 21" of the text as the only layer, or the reason of its refusal.
std::string matrix(const std::string& text, MatrixLabels labels = MatrixLabels::kDetect) {
  const test::TempFolder folder;
  folder.file("maps/1.csv", text);
  LayerRecordOptions options;
  options.labels = labels;
  try {
    const LayerRecord r = read_layer_files({.heights = folder.path() / "maps"}, options);
    double sum = 0.0;
    for (const double h : r.heights[1].cells) sum += std::isnan(h) ? 0.0 : h;
    return std::to_string(r.grid.nx) + " x " + std::to_string(r.grid.ny) + ", " + std::to_string(r.points) +
           " heights, sum " + std::to_string(std::lround(sum));
  } catch (const UsageError& e) {
    return e.what();
  }
}

const std::string kSix = "3 x 2, 6 heights, sum 222";

}  // namespace

TEST_CASE("The layer is the number behind the word layer, or the one that varies") {
  CHECK(layers_of({"1.csv", "2.csv", "10.csv"}) == "1 2 10");
  CHECK(layers_of({"L1_t107.csv", "L2_t114.csv", "L3_t121.csv"}) == "1 2 3");
  CHECK(layers_of({"run7-layer003-v2.csv", "run8-layer004-v2.csv"}) == "3 4");
  CHECK(layers_of({"2026-11-28_scan_1.csv", "2026-11-28_scan_2.csv"}) == "1 2");
  CHECK(layers_of({"scan001_v2.csv", "scan002_v2.csv"}) == "1 2");
  CHECK(layers_of({"layer 4.csv", "layer 5 of 9.csv"}) == "4 5");
}

TEST_CASE("Numbers that could both be the layer are refused with both readings, and an option chooses") {
  const std::vector<std::string> names{"a1_107.csv", "a2_114.csv", "a3_121.csv"};
  CHECK_THAT(layers_of(names), Contains("1, 2, 3 (--layer-number 1), or 107, 114, 121 (--layer-number 2)"));
  CHECK(layers_of(names, 1) == "1 2 3");
  CHECK(layers_of(names, -1) == "107 114 121");
  CHECK_THAT(layers_of(names, 3), Contains("the name has 2 numbers"));
  CHECK_THAT(layers_of({"a1.csv", "a2_b3.csv"}),
             Contains("has 1 numbers in its name") && Contains("--layer-number"));
  CHECK_THAT(layers_of({"layer1.csv", "layer01.csv"}), Contains("a second file of layer 1"));
  CHECK_THAT(layers_of({"layer99999999999.csv"}), Contains("no layer from 0 to 100000"));
}

TEST_CASE("Names and numbers that pandas writes around a matrix are no heights") {
  CHECK(matrix("11,22,33\n44,55,57\n") == kSix);
  CHECK(matrix(",0,1,2\n0,11,22,33\n1,44,55,57\n") == kSix);
  CHECK(matrix(";0;1;2\n0;11,0;22,0;33\n1;44;55;57\n") == kSix);
  CHECK(matrix("y/x,0.0,0.5,1.0\n0.0,11,22,33\n0.5,44,55,57\n") == kSix);
  CHECK(matrix("a,b,c\n11,22,33\n44,55,57\n") == kSix);
  CHECK(matrix(",a,b,c\n0,11,22,33\n1,44,55,57\n") == kSix);
  CHECK(matrix("\"\",\"V1\",\"V2\",\"V3\"\n\"1\",11,22,33\n\"2\",44,55,57\n") == kSix);
  CHECK(matrix("r1,11,22,33\nr2,44,55,57\n") == kSix);
  CHECK_THAT(matrix("11,2x,33\n44,55,57\n"), Contains("1.csv:1: column 2 = 2x: is not a finite number"));
  CHECK(matrix("# x\n11 22 33\n44 55 57\n") == kSix);
}

TEST_CASE("A missing corner of a matrix is a missing height") {
  CHECK(matrix(",22,30\n44,55,57\n") == "3 x 2, 5 heights, sum 208");
  CHECK(matrix("11,22,33\n,,\n44,55,57\n") == "3 x 3, 6 heights, sum 222");
  CHECK_THAT(matrix(",20,30,40\n15,1,2,3\n25,4,5,6\n35,7,8,9\n"),
             Contains("beside a missing one (--labels none)"));
}

TEST_CASE(
    "A first row or column 0, 1, 2 without a corner is refused with both readings, and an option chooses") {
  const std::string row = "0,1,2\n11,22,33\n44,55,57\n";
  CHECK_THAT(matrix(row), Contains("1.csv:1: the first row counts 0, 1, 2") && Contains("--labels none"));
  CHECK(matrix(row, MatrixLabels::kRow) == kSix);
  CHECK(matrix(row, MatrixLabels::kNone) == "3 x 3, 9 heights, sum 225");
  const std::string column = "0,11,22\n1,33,44\n2,55,57\n";
  CHECK_THAT(matrix(column), Contains("the first column counts 0, 1, 2"));
  CHECK(matrix(column, MatrixLabels::kColumn) == "2 x 3, 6 heights, sum 222");
}

TEST_CASE("Tables of other programs have their layers, whatever separates their columns") {
  for (const char* text :
       {"layer,x_mm,height_mm\n1,0,0.5\n1,1,0.25\n2,0,1\n",
        "sep=;\nlayer;x_mm;height_mm\n1;0;0,5\n1;1;0,25\n2;0;1\n",
        "layer x_mm height_mm\n1 0 0.5\n1 1 0.25\n2 0 1\n",
        "\xef\xbb\xbflayer\tX [mm]\tHeight (mm)\r\n1\t0\t0,5\r\n1\t1\t0,25\r\n2\t0\t1\r\n"}) {
    CAPTURE(text);
    const LayerRecord r = read_layer_table(text, "record.csv", {});
    REQUIRE(r.heights.size() == 3);
    CHECK(r.heights[1].cells == std::vector<double>{0.5, 0.25});
    CHECK(r.points == 3);
  }
  CHECK_THROWS_WITH(read_layer_table("1,0,0.5\n1,1,0.25\n", "record.csv", {}),
                    Contains("record.csv:1: numbers, where the names of the columns are needed"));
}
