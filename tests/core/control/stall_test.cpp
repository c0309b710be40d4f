#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/controller.h"
#include "core/control/stall_bound.h"
#include "core/grid/random.h"

namespace firn::control {
namespace {

Setup setup_of(int n, double target_mm) {
  Setup s;
  s.grid = {n, n, 0.25, 0.25, 0.0, 0.0};
  s.target = HeightMap(s.grid, target_mm);
  s.mask = Mask(s.grid, 1);
  s.model = {0.0066, 0.0002, 0.00005};
  return s;
}

struct Print {
  int layers = 0;
  std::int64_t droplets_of_last_ten = 0;
  std::string reason;
};

/// A printer on which two cells never rise, measured with noise.
Print print(const ControlOptions& options, int most_layers) {
  const Setup setup = setup_of(12, 0.05);
  const auto scheme = make_controller(setup, options);
  HeightMap height(setup.grid, 0.0);
  RandomStream random(3, Purpose::kTest);
  Print p;
  for (int layer = 0; layer < most_layers; ++layer) {
    HeightMap measured = height;
    for (double& h : measured.cells)
      h += 0.001 * (random.uniform() + random.uniform() + random.uniform() - 1.5) * 2.0;
    const Decision d = scheme->decide({measured, layer, 0, 0.001});
    p.reason = d.reason;
    if (d.kind != Decision::Kind::kPrint) return p;
    p.layers = layer + 1;
    for (std::size_t c = 0; c < height.size(); ++c)
      if (c != 40 && c != 91) height.cells[c] += setup.model.layer_height_mm() * d.drops.cells[c];
  }
  return p;
}

TEST_CASE("MPC ends when its layers no longer better the part, not when max_layers is reached") {
  ControlOptions options;
  options.scheme = "mpc";
  options.stall_layers = 0;
  const Print for_ever = print(options, 60);
  CHECK(for_ever.layers == 60);
  options.stall_layers = 6;
  const Print ended = print(options, 60);
  CHECK(ended.layers >= 7);  // as many as the height takes
  CHECK(ended.layers <= 7 + 2 + 6);
  CHECK_THAT(ended.reason, Catch::Contains("no more than the noise"));
}

/// A scheme that always prints.
class Always final : public LayerControllerBase {
 public:
  Decision decide(const Measurement& m) override {
    Decision d;
    d.kind = Decision::Kind::kPrint;
    d.drops = DropletPattern(m.height.spec, 1);
    return d;
  }
};

TEST_CASE("a part that rises, however slowly, beyond the noise is never taken for stalled") {
  const Setup setup = setup_of(20, 1.0);
  ControlOptions options;
  options.stall_layers = 6;
  const double noise_mm = 0.001, limit_mm = StallDetector::kSigmas * noise_mm * std::sqrt(2.0 / 400.0);
  for (const double step_mm : {0.9 * limit_mm / 6.0, 1.1 * limit_mm / 6.0}) {
    StallBound bound(std::make_unique<Always>(), setup, options);
    int ended = -1;
    for (int layer = 0; layer < 40 && ended < 0; ++layer)
      if (bound.decide({HeightMap(setup.grid, layer * step_mm), layer, 0, noise_mm}).kind !=
          Decision::Kind::kPrint)
        ended = layer;
    CHECK(ended == (step_mm * 6.0 < limit_mm ? 6 : -1));
  }
}

TEST_CASE("a layer that is measured again counts once, and a print that begins again has no past") {
  const Setup setup = setup_of(5, 1.0);
  ControlOptions options;
  options.stall_layers = 2;
  StallBound bound(std::make_unique<Always>(), setup, options);
  const auto prints = [&](double height_mm, int layer, int attempt) {
    return bound.decide({HeightMap(setup.grid, height_mm), layer, attempt, 0.0}).kind ==
           Decision::Kind::kPrint;
  };
  CHECK(prints(0.5, 0, 0));
  CHECK(prints(0.1, 0, 1));  // the first measurement of layer 0 was wrong
  CHECK(prints(0.2, 1, 0));
  CHECK(prints(0.3, 2, 0));
  CHECK(prints(0.0, 0, 0));
  CHECK(prints(0.05, 1, 0));
  CHECK(prints(0.06, 2, 0));
}

}  // namespace
}  // namespace firn::control
