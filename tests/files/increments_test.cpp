// Increments with holes, drawn by seed at three scales: mm beads, 0.1 mm ice, um droplets.
#include "files/increments.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/grid/random.h"
#include "core/options/range.h"
#include "files/layer_record.h"

using namespace firn;
using Catch::Contains;

namespace {

constexpr double kScales_mm[] = {1.5, 0.1, 0.007};  // of an increment

struct Record {
  std::vector<HeightMap> whole, holed;  // increments [layer], layer 0 without any
  std::vector<HeightMap> heights;       // sums of the whole ones
  std::int64_t holes = 0;               // with a later increment of the cell
};

// A share of the increments is missing; those of a layer differ along x by a straight line, which a line
// bridges.
Record drawn(std::uint64_t seed, double scale_mm, double share, int layers = 12, int nx = 40) {
  RandomStream random(seed, Purpose::kInstance, 0, 0);
  const GridSpec grid{nx, 1, 2.0, 2.0, 0.0, 0.0};
  Record r;
  r.whole.assign(1, HeightMap(grid, kNotMeasured));
  r.heights.assign(1, HeightMap(grid, 0.0));
  for (int k = 1; k <= layers; ++k) {
    HeightMap map(grid, 0.0);
    const double at_left = scale_mm * (1.0 + 0.2 * random.normal()),
                 slope = 0.2 * scale_mm * random.normal() / nx;
    for (int i = 0; i < nx; ++i) map.at(i, 0) = at_left + slope * i;
    r.whole.push_back(map);
    HeightMap sum = r.heights.back();
    for (std::size_t c = 0; c < sum.size(); ++c) sum.cells[c] += map.cells[c];
    r.heights.push_back(std::move(sum));
  }
  r.holed = r.whole;
  for (int k = 1; k < layers; ++k)  // ends and the last layer stay
    for (int i = 1; i + 1 < nx; ++i)
      if (random.uniform() < share) {
        r.holed[std::size_t(k)].at(i, 0) = kNotMeasured;
        ++r.holes;
      }
  return r;
}

std::string table_of(const std::vector<HeightMap>& increments, int first) {
  std::string text = "layer,segment,dh_mm\n";
  for (std::size_t k = std::size_t(first); k < increments.size(); ++k)
    for (std::size_t c = 0; c < increments[k].size(); ++c) {
      const double v = increments[k].cells[c];
      text +=
          std::to_string(k) + "," + std::to_string(c) + "," + (std::isnan(v) ? "" : shortest_text(v)) + "\n";
    }
  return text;
}

bool says(const LayerRecord& r, const std::string& words) {
  return std::ranges::any_of(r.assumptions,
                             [&](const std::string& line) { return line.find(words) != line.npos; });
}

}  // namespace

TEST_CASE("Gaps of increments that lie on a line are bridged to the true heights at any scale") {
  for (const double scale_mm : kScales_mm)
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Record r = drawn(seed, scale_mm, 0.02);
      const IntegratedHeights out = integrate_increments(r.holed, HeightMap(r.holed[0].spec, 0.0));
      REQUIRE(out.base == 0);
      CHECK(out.bridges == r.holes);
      for (std::size_t k = 0; k < r.heights.size(); ++k)
        for (std::size_t c = 0; c < r.heights[k].size(); ++c) {
          CHECK(std::abs(out.heights[k].cells[c] - r.heights[k].cells[c]) < 1e-12 * scale_mm * 1e3);
          CHECK(bool(out.bridged[k].cells[c]) == (k > 0 && std::isnan(r.holed[k].cells[c])));
        }
    }
}

TEST_CASE("Heights count from the layer below the first increment, and that layer is named") {
  std::vector<HeightMap> increments = drawn(7, 1.5, 0.0).whole;
  increments.insert(increments.begin(), 2, increments.front());
  const LayerRecord r = read_layer_table(table_of(increments, 1), "wall.csv", {});
  CHECK(r.base == 2);
  CHECK(r.missing == 0);
  CHECK(r.points == 12 * 40);
  CHECK(r.heights[2].cells[3] == 0.0);
  CHECK(r.heights[3].cells[3] == Approx(increments[3].cells[3]).margin(1e-6));
  CHECK(r.bridged[2].cells[3] == 1);
  CHECK(says(r, "no increment is told up to layer 2"));
}

TEST_CASE("Few missing increments leave no height missing above them") {
  const Record drawn_record = drawn(11, 1.5, 0.015, 104, 48);
  REQUIRE(drawn_record.holes > 30);
  const LayerRecord r = read_layer_table(table_of(drawn_record.holed, 0), "wall.csv", {});
  CHECK(r.missing == 0);
  CHECK(r.bridges == drawn_record.holes);
  CHECK(r.points == 104 * 48 - drawn_record.holes);
  CHECK(says(r, std::to_string(drawn_record.holes) + " missing increments"));
}

TEST_CASE("A cell has no height after its last increment") {
  std::vector<HeightMap> increments = drawn(3, 0.1, 0.0).whole;
  for (std::size_t k = 9; k < increments.size(); ++k) increments[k].at(5, 0) = kNotMeasured;
  const IntegratedHeights out = integrate_increments(increments, HeightMap(increments[0].spec, 0.0));
  CHECK(out.bridges == 0);
  CHECK(std::isfinite(out.heights[8].at(5, 0)));
  CHECK(std::isnan(out.heights[9].at(5, 0)));
}

TEST_CASE("A layer without any increment takes those between the layers before and after") {
  std::vector<HeightMap> increments = drawn(5, 0.1, 0.0).whole;
  std::ranges::fill(increments[6].cells, kNotMeasured);
  const IntegratedHeights out = integrate_increments(increments, HeightMap(increments[0].spec, 0.0));
  const double between = 0.5 * (increments[5].at(7, 0) + increments[7].at(7, 0));
  CHECK(out.heights[6].at(7, 0) - out.heights[5].at(7, 0) == Approx(between));
  CHECK(out.bridged[6].count() == 40);
}

TEST_CASE("Targets and errors of each layer tell the same: target = height - error") {
  const LayerRecord by_error = read_layer_table(
      "layer,segment,dh_mm,height_error_mm\n1,0,,0.5\n2,0,1.25,0.25\n3,0,1.5,-0.25\n", "e.csv", {});
  CHECK(by_error.targets[2].cells[0] == Approx(1.0));
  CHECK(by_error.targets[3].cells[0] == Approx(3.0));
  const LayerRecord by_target =
      read_layer_table("layer,segment,dh_mm,target_mm\n1,0,,1.5\n2,0,1.25,3\n3,0,1.5,4.5\n", "t.csv", {});
  CHECK(by_target.heights[1].cells[0] == 1.5);  // the base is at its target
  CHECK(by_target.heights[3].cells[0] == Approx(4.25));
}

TEST_CASE("Speeds are read in mm/s, and refused beside another input") {
  const LayerRecord r = read_layer_table("layer,segment,dh_mm,speed_mm_min\n1,0,1.5,600\n", "v.csv", {});
  CHECK(r.input_is_speed);
  CHECK(r.inputs[0].cells[0] == Approx(10.0));
  CHECK_THROWS_WITH(read_layer_table("layer,segment,dh_mm,speed,drops\n1,0,1.5,6,2\n", "v.csv", {}),
                    Contains("one input told twice"));
}
