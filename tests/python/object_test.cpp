// Objects of classes in Python, as the plug-in calls them.
#include <catch2/catch.hpp>

#include <string>

#include "python/host/load.h"

namespace firn {
namespace {

python::Parcel pass_on(const GridSpec& grid) {
  python::Parcel given;
  given.text = "layer 1";
  given.arrays["height_mm"] = {{grid.ny, grid.nx}, std::vector<double>(grid.size(), 0.5)};
  given.set("layer", 0.0);
  return given;
}

std::unique_ptr<python::Object> ink(const std::string& body, double longest_s = 10.0) {
  const std::string text =
      "class Ink:\n def __init__(self, s): self.s = s\n def deposit(self, d):\n  " + body + "\n";
  python::Parcel setup;
  setup.set_grid({3, 2, 0.25, 0.25, 0.0, 0.0});
  setup.set_seed(9'000'000'000'000'000'001u);
  return python::host().make_object(python::Kind::kPlant, {{"ink.py", text}}, {"Ink", ""}, setup, longest_s);
}

const GridSpec kGrid{3, 2, 0.25, 0.25, 0.0, 0.0};

TEST_CASE("a class that takes too long is named, and can be called again") {
  const auto slow = ink("\n  while d.layer == 0: pass\n  return d.height_mm", 0.3);
  python::Parcel given = pass_on(kGrid);
  CHECK_THROWS_WITH(slow->call(given), Catch::Contains("deposit of layer 1 took longer than 0.3"));
  given.set("layer", 1.0);
  CHECK(slow->call(given).arrays.at("height_mm").values == std::vector<double>(6, 0.5));
}

TEST_CASE("a seed of 63 bits and the grid's shape reach a class exactly") {
  const auto seed =
      ink("return d.height_mm + (self.s.seed == 9000000000000000001) + (self.s.shape == (2, 3))");
  CHECK(seed->call(pass_on(kGrid)).arrays.at("height_mm").values == std::vector<double>(6, 2.5));
}

TEST_CASE("what a class is given cannot be written to") {
  CHECK_THROWS_WITH(ink("d.height_mm[0] = 1; return d.height_mm")->call(pass_on(kGrid)),
                    Catch::Contains("read-only"));
}

}  // namespace
}  // namespace firn
