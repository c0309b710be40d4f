// A cylinder on 40 x 40 cells, printed by the level controller of docs/write-a-controller.md and by the same
// controller in Python.
#pragma once

#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "core/control/controller.h"
#include "core/deposition/height_change.h"
#include "core/grid/random.h"
#include "core/grid/shapes.h"
#include "procs/controller/python_controller.h"

namespace firn::test {

inline Blob python_input(const std::string& name, const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {std::string(kPythonRole) + name, "", {begin, begin + text.size()}};
}

inline std::string source_text(const std::string& path) {
  std::ifstream in(std::string(FIRN_SOURCE_DIR) + "/" + path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The part of the README's first table: a cylinder of 0.4 mm, 53 layers.
inline control::Setup cylinder_setup() {
  const GridSpec grid{40, 40, 0.263256, 0.263256, 0.0, 0.0};
  ShapeSpec shape;
  shape.diameter_mm = 10.0;
  shape.height_mm = 0.4;
  const Target target = make_shape(shape, grid);
  return {grid, target.height, target.mask, {0.0044, 0.0006, 0.0002}};
}

inline std::unique_ptr<control::LayerController> python_level(const control::Setup& setup) {
  control::ControlOptions options;
  options.scheme = "python:level.py:Level";
  return make_python_controller(setup, options,
                                {python_input("level.py", source_text("experiments/python/level.py"))});
}

/// Returns the decisions of a print on the height-change model, whose maps have noise of 1 um.
/// @param each is called around a decision: each([&] { … })
template <class Each>
std::vector<control::Decision> decisions(control::LayerController& controller, const control::Setup& setup,
                                         std::uint64_t seed, Each each) {
  deposition::HeightChange<1> nature(setup.grid, deposition::stencil_of(setup.model), setup.border);
  RandomStream noise(seed, Purpose::kTest);
  HeightMap height(setup.grid, 0.0);
  std::vector<control::Decision> all;
  for (int layer = 0; layer < 300; ++layer) {
    HeightMap map = height;
    for (double& h : map.cells) h += 0.001 * noise.normal();
    each([&] { all.push_back(controller.decide({map, layer, 0, 0.001})); });
    if (all.back().kind != control::Decision::Kind::kPrint) break;
    nature.deposit(height, all.back().drops);
  }
  return all;
}

}  // namespace firn::test
