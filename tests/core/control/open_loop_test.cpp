#include "core/control/open_loop.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;

namespace {

ControlOptions open_loop(int layers = 0) {
  ControlOptions o;
  o.scheme = "open_loop";
  o.open_loop.layers = layers;
  return o;
}

}  // namespace

TEST_CASE("Open loop prints round(target / layer height) layers of the whole mask and then ends") {
  const Setup s = cylinder_setup();  // 0.4 mm / 7.6 um = 52.6
  const auto controller = make_controller(s, open_loop());
  const LoopResult r = run_loop(*controller, s, {});
  CHECK(r.ended);
  CHECK(r.layers == 53);
  for (int k = 0; k < 53; ++k) CHECK(r.decisions[std::size_t(k)].drops.total() == s.mask.count());
  CHECK(r.decisions.back().drops.total() == 0);
}

TEST_CASE("Open loop slices each cell by its own height") {
  ShapeSpec wedge;
  wedge.kind = "wedge";
  wedge.height_mm = 0.1;
  wedge.low_height_mm = 0.02;
  wedge.width_mm = 9.0;
  wedge.depth_mm = 5.0;
  Setup s = cylinder_setup();
  const Target t = make_shape(wedge, s.grid);
  s.target = t.height;
  s.mask = t.mask;
  const auto controller = make_controller(s, open_loop());
  HeightMap layers(s.grid);
  const LoopResult r = run_loop(*controller, s, {});
  for (const Decision& d : r.decisions)
    for (std::size_t c = 0; c < layers.size(); ++c) layers.cells[c] += d.drops.cells[c];
  for (std::size_t c = 0; c < layers.size(); ++c)
    CHECK(layers.cells[c] ==
          (s.mask.cells[c] ? std::floor(s.target.cells[c] / s.model.layer_height_mm() + 0.5) : 0.0));
}

TEST_CASE("Open loop does not listen to the measurement") {
  const Setup s = cylinder_setup();
  const auto a = make_controller(s, open_loop()), b = make_controller(s, open_loop());
  const HeightMap low(s.grid, 0.0), high(s.grid, 1.0);
  CHECK(a->decide({low, 7, 0, 0.0}).drops == b->decide({high, 7, 2, 0.01}).drops);
}

TEST_CASE(
    "III-C in two dimensions: an open-loop cylinder shrinks at the edge, layer by layer further in, and is "
    "flat inside") {
  const Setup s = cylinder_setup();
  const auto controller = make_controller(s, open_loop(4));
  const LoopResult r = run_loop(*controller, s, {});
  CHECK(r.layers == 4);
  const double full = 4 * s.model.layer_height_mm();
  CHECK(r.height.at(20, 20) == Approx(full).epsilon(1e-12));
  int edge = 0;
  while (!s.mask.at(edge, 20)) ++edge;
  for (int depth = 0; depth < 4; ++depth) CHECK(r.height.at(edge + depth, 20) < full - 1e-7);
  for (int depth = 0; depth < 3; ++depth)
    CHECK(r.height.at(edge + depth, 20) < r.height.at(edge + depth + 1, 20));
}

TEST_CASE(
    "FIT Figs. 11/12: the open-loop cylinder at 20 and 40 percent variation has the paper's mean errors") {
  const Setup s = cylinder_setup();
  for (const auto& [variation, mean_um] : {std::pair{0.2, 44.1}, {0.4, 84.7}}) {
    const auto controller = make_controller(s, open_loop(54));
    const LoopResult r = run_loop(*controller, s, {variation, 0.0, 0.0, 3});
    CHECK(std::abs(r.stats.mean_mm * 1e3 - mean_um) < 0.5);
  }
}
