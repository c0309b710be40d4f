#include "core/control/threshold.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;

namespace {

ControlOptions threshold(double threshold_mm = 0.0, double layer_height_mm = 0.0) {
  ControlOptions o;
  o.scheme = "threshold";
  o.threshold = {threshold_mm, layer_height_mm};
  return o;
}

}  // namespace

TEST_CASE(
    "[7] as Lu 2015, section I tells it: a droplet exactly where the layer is short by more than the "
    "threshold") {
  const Setup s = cylinder_setup();
  const double dh = s.model.layer_height_mm();
  RandomStream random(7, Purpose::kTest);
  for (int n = 0; n < 40; ++n) {
    const double limit = random.uniform(0.0005, 0.02);
    const int layer = int(random.below(70));
    const auto controller = make_controller(s, threshold(limit));
    HeightMap h(s.grid);
    for (double& v : h.cells) v = layer * dh + random.uniform(-0.03, 0.03);
    const Decision d = controller->decide({h, layer, 0, 0.001});
    for (std::size_t c = 0; c < h.size(); ++c) {
      const bool tagged =
          s.mask.cells[c] && std::min((layer + 1) * dh, s.target.cells[c]) - h.cells[c] > limit;
      CHECK(int(d.drops.cells[c]) == int(tagged));
    }
  }
}

TEST_CASE("the default threshold is half a layer, where one droplet on flat ground begins to pay") {
  const Setup s = cylinder_setup();
  const double dh = s.model.layer_height_mm();
  CHECK(Threshold(s, threshold()).threshold_mm() == 0.5 * dh);
  CHECK(Threshold(s, threshold(0.0, 0.01)).threshold_mm() == 0.005);
  CHECK(Threshold(s, threshold(0.002)).threshold_mm() == 0.002);
  const auto controller = make_controller(s, threshold());
  for (const double e : {0.49 * dh, 0.51 * dh}) {
    const Decision d = controller->decide({HeightMap(s.grid, 10 * dh - e), 9, 0, 0.0});
    CHECK((d.drops.total() > 0) == (std::abs(e - dh) < e));
  }
}

TEST_CASE("an undisturbed print under threshold feedback has no cell short by more than the threshold") {
  const Setup s = cylinder_setup();
  const auto controller = make_controller(s, threshold());
  const LoopResult r = run_loop(*controller, s, {});
  CHECK(r.ended);
  CHECK(r.stats.min_mm >= -0.5 * s.model.layer_height_mm());
}

TEST_CASE("threshold feedback holds a print that grows too fast, which open loop does not") {
  const Setup s = cylinder_setup();
  const LoopConditions nature{0.4, 0.001, 0.0, 5};
  const auto closed = make_controller(s, threshold());
  ControlOptions o;
  o.scheme = "open_loop";
  const auto open = make_controller(s, o);
  const LoopResult c = run_loop(*closed, s, nature), b = run_loop(*open, s, nature);
  CHECK(c.ended);
  CHECK(c.stats.rms_mm < 0.1 * b.stats.rms_mm);
}

TEST_CASE("threshold feedback keeps no state: a decision depends on the measurement alone") {
  const Setup s = cylinder_setup();
  const auto a = make_controller(s, threshold()), b = make_controller(s, threshold());
  a->decide({HeightMap(s.grid, 0.1), 3, 0, 0.0});
  const HeightMap h(s.grid, 0.07);
  CHECK(a->decide({h, 9, 1, 0.0}).drops == b->decide({h, 9, 0, 0.001}).drops);
}

TEST_CASE("threshold feedback refuses a threshold or a layer below zero and names it") {
  const Setup s = cylinder_setup();
  CHECK_THROWS_WITH(make_controller(s, threshold(-0.001)),
                    Catch::Contains("threshold_mm") && Catch::Contains("-0.001"));
  CHECK_THROWS_WITH(make_controller(s, threshold(0.0, std::nan(""))), Catch::Contains("layer_height_mm"));
}
