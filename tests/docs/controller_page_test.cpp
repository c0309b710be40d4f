#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>

#include "core/grid/random.h"
#include "core/grid/shapes.h"
#include "tests/docs/learning_controller.h"
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

TEST_CASE("the page shows the learning controller as it is compiled here") {
  const std::string code = file("tests/docs/learning_controller.h");
  const std::size_t from = code.find("inline constexpr"), until = code.find("\n}  // namespace");
  REQUIRE(file("docs/write-a-controller.md").find(code.substr(from, until - from)) != std::string::npos);
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

struct Learning {
  explicit Learning(double rate = 0.3) {
    ControlOptions options;
    options.extra.numbers["learning_rate"] = rate;
    controller.emplace(setup, options);
  }
  Decision decide(const HeightMap& height, int layer, int attempt = 0) {
    return controller->decide({height, layer, attempt, 0.0});
  }
  Setup setup{GridSpec{6, 5, 0.25, 0.25, 0.0, 0.0},
              HeightMap(GridSpec{6, 5, 0.25, 0.25, 0.0, 0.0}, 0.04),
              Mask(GridSpec{6, 5, 0.25, 0.25, 0.0, 0.0}, 1),
              {0.0044, 0.0006, 0.0002},
              deposition::Border::kKeep};
  std::optional<LearningController> controller;
};

TEST_CASE("a second measurement of a layer replaces the first in the learning controller's memory") {
  RandomStream random(4, Purpose::kTest);
  Learning once, twice;
  HeightMap height(once.setup.grid, 0.0);
  for (int layer = 0; layer < 12; ++layer) {
    HeightMap wrong = height;  // what a disturbed scan may tell
    for (double& h : wrong.cells) h += 0.02 * random.uniform();
    twice.decide(wrong, layer, 0);
    const Decision a = once.decide(height, layer), b = twice.decide(height, layer, 1);
    REQUIRE(a.drops.cells == b.drops.cells);
    REQUIRE(a.objective_mm == b.objective_mm);
    for (std::size_t c = 0; c < height.size(); ++c) height.cells[c] += 0.0061 * a.drops.cells[c];
  }
}

TEST_CASE("the learning controller foretells a layer by the rise that it has measured") {
  const double true_mm = 0.0061, model_mm = 0.0076;  // a droplet gives a fifth less than the model says
  for (const double rate : {0.3, 1.0}) {
    Learning run(rate);
    HeightMap height(run.setup.grid, 0.0);
    Decision d;
    for (int layer = 0; layer < 5; ++layer) {
      d = run.decide(height, layer);
      REQUIRE(d.drops.total() == std::int64_t(height.size()));
      if (layer < 4)
        for (double& h : height.cells) h += true_mm;
    }
    const double gain = 1.0 + (true_mm / model_mm - 1.0) * (1.0 - std::pow(1.0 - rate, 4));
    CHECK(d.objective_none_mm - d.objective_mm == Approx(gain * model_mm).epsilon(1e-6));
  }
}

TEST_CASE("a rate that no learning has is refused by its name") {
  for (const double rate : {0.0, -1.0, 1.5})
    CHECK_THROWS_WITH(Learning(rate), Catch::Contains("extra.learning_rate"));
}

}  // namespace
}  // namespace firn::control
