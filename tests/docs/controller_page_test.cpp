#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "core/grid/random.h"
#include "core/grid/shapes.h"
#include "tests/docs/level_controller.h"

namespace firn::control {
namespace {

std::string file(const std::string& path) {
  std::ifstream in(std::string(FIRN_SOURCE_DIR) + "/" + path);
  REQUIRE(in.good());
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_CASE("the controller page shows the code that is compiled here, and it keeps to 50 lines") {
  const std::string code = file("tests/docs/level_controller.h");
  REQUIRE(file("docs/write-a-controller.md").find(code) != std::string::npos);
  REQUIRE(std::count(code.begin(), code.end(), '\n') <= 50);
}

TEST_CASE("the page's controller prints a cylinder flatter than the open loop does") {
  const GridSpec grid{20, 20, 0.263256, 0.263256, 0.0, 0.0};
  ShapeSpec shape;
  shape.diameter_mm = 4.6;
  shape.height_mm = 0.1;
  const Target target = make_shape(shape, grid);
  const Setup setup{grid, target.height, target.mask, {0.0044, 0.0006, 0.0002}};
  const auto print = [&](LayerController& controller) {
    deposition::HeightChange<1> nature(grid, deposition::stencil_of(setup.model), setup.border);
    HeightMap height(grid, 0.0);
    for (int layer = 0; layer < 200; ++layer) {
      const Decision d = controller.decide({height, layer, 0, 0.0});
      if (d.kind != Decision::Kind::kPrint) return error_stats(height, target.height, target.mask).rms_mm;
      nature.deposit(height, d.drops);
    }
    FAIL("the print does not end");
    return 0.0;
  };
  ControlOptions options;
  options.scheme = "open_loop";
  LevelController level(setup, options);
  REQUIRE(print(level) < 0.5 * print(*make_controller(setup, options)));
}

}  // namespace
}  // namespace firn::control
