// control.target_offset_mm: schemes aim above or below the target, from the next decision on.
#include "core/control/target_offset.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/control/controller.h"
#include "core/control/stall_bound.h"
#include "core/control/surface/surface_controller.h"
#include "core/grid/random.h"

namespace firn::control {
namespace {

constexpr double kUnit_mm = 1.0 / 1024.0;  // sums of it have no rounding

Setup raised_part(double target_mm) {
  Setup s;
  s.grid = {10, 8, 0.25, 0.25, 0.0, 0.0};
  s.target = HeightMap(s.grid, target_mm);
  s.mask = Mask(s.grid, 1);
  s.model = {0.0066, 0.0002, 0.00005};
  return s;
}

ControlOptions aiming(const std::string& scheme, double offset_mm) {
  ControlOptions o;
  o.scheme = scheme;
  o.target_offset_mm = offset_mm;
  return o;
}

/// Mean height at the end of a print whose offset changes after `layers` layers, on a printer that obeys the
/// model's layer height.
double mean_end_mm(const std::string& scheme, double later_mm, int layers) {
  const Setup setup = raised_part(0.1);
  const auto controller = make_controller(setup, aiming(scheme, 0.0));
  HeightMap height(setup.grid, 0.0);
  for (int layer = 0; layer < 60; ++layer) {
    if (layer == layers) controller->use_options(aiming(scheme, later_mm));
    const Decision d = controller->decide({height, layer, 0, 0.0});
    if (d.kind != Decision::Kind::kPrint) break;
    for (std::size_t c = 0; c < height.size(); ++c)
      height.cells[c] += setup.model.layer_height_mm() * d.drops.cells[c];
  }
  double sum = 0.0;
  for (const double h : height.cells) sum += h;
  return sum / double(height.size());
}

}  // namespace

TEST_CASE("with the target's offset a scheme decides what it would about a target that is higher by it") {
  const double offset_mm = 12.0 * kUnit_mm;
  for (const char* name : {"mpc", "smf", "threshold"}) {
    const auto shifted = make_controller(raised_part(64.0 * kUnit_mm), aiming(name, offset_mm));
    const auto plain = make_controller(raised_part(64.0 * kUnit_mm + offset_mm), aiming(name, 0.0));
    HeightMap height(raised_part(0.0).grid, 0.0);
    for (std::size_t c = 0; c < height.size(); ++c)
      height.cells[c] = kUnit_mm * double(60 + random_below({5, Purpose::kTest, 0, 0, std::uint32_t(c)}, 24));
    const Measurement m{height, 100, 0, 0.0};  // beyond the last reference plane
    const Decision a = shifted->decide(m), b = plain->decide(m);
    INFO(name);
    CHECK(a.kind == b.kind);
    CHECK(a.drops.cells == b.drops.cells);
    CHECK(a.objective_mm == Approx(b.objective_mm).epsilon(1e-6));
  }
}

TEST_CASE("the target's offset, changed between layers, moves where a print ends by as much") {
  for (const char* name : {"mpc", "smf", "threshold"}) {
    INFO(name);
    const double as_sliced = mean_end_mm(name, 0.0, 5), layer_mm = raised_part(0.0).model.layer_height_mm();
    for (const double offset_mm : {-0.03, 0.03})
      CHECK(std::abs(mean_end_mm(name, offset_mm, 5) - as_sliced - offset_mm) < layer_mm);
  }
}

TEST_CASE("a target's offset that is out of its range is refused, and the one before stays") {
  const auto controller = make_controller(raised_part(0.1), aiming("mpc", 0.0));
  CHECK_THROWS_WITH(controller->use_options(aiming("mpc", 11.0)), Catch::Contains("target_offset_mm"));
  CHECK_THROWS_WITH(make_controller(raised_part(0.1), aiming("smf", std::nan(""))),
                    Catch::Contains("target_offset_mm"));
}

TEST_CASE("a part whose target moves is not taken for stalled because its errors grow") {
  class Prints final : public LayerControllerBase {
   public:
    Decision decide(const Measurement& m) override {
      Decision d;
      d.kind = Decision::Kind::kPrint;
      d.drops = DropletPattern(m.height.spec, 1);
      return d;
    }
  };
  const Setup setup = raised_part(0.1);
  ControlOptions o = aiming("mpc", 0.0);
  o.stall_layers = 3;
  TargetOffset bound(std::make_unique<StallBound>(std::make_unique<Prints>(), setup, o), o);
  const auto prints = [&](int layer, double height_mm) {
    return bound.decide({HeightMap(setup.grid, height_mm), layer, 0, 0.0}).kind == Decision::Kind::kPrint;
  };
  for (int layer = 0; layer <= 10; ++layer) REQUIRE(prints(layer, 0.01 * layer));
  o.target_offset_mm = 0.05;
  bound.use_options(o);
  for (int layer = 11; layer <= 15; ++layer) CHECK(prints(layer, 0.01 * layer));
  CHECK(prints(16, 0.15));
  CHECK(prints(17, 0.15));
  CHECK_FALSE(prints(18, 0.15));
}

// e_{k+1} = e_k - u_k (5.16): a printer without a disturbance.
TEST_CASE("paths answer the target's offset as an error, and observers do not take it for a disturbance") {
  const GridSpec grid{9, 7, 1.0, 1.0, 0.0, 0.0};
  const Grid<std::uint8_t> part(grid, 1);
  constexpr double kStep_mm = 1.0, kOffset_mm = 0.25;
  for (const std::string scheme : {"smf", "smf_adaptive", "smf_foresee"}) {
    SurfaceOptions o;
    o.scheme = scheme;
    o.interval_mm = kStep_mm;
    o.version = SurfaceVersion::kValveFrequency;
    o.smf = {1.0, 0.0, 0.0, 0.5};
    const auto controller = make_surface_controller(o);
    double e = 0.0;
    INFO(scheme);
    for (int k = 1; k <= 9; ++k) {
      if (k == 4) {
        o.target_offset_mm = kOffset_mm;
        controller->use_options(o);
      }
      const SurfaceDecision d = controller->decide({HeightMap(grid, k - e), part, double(k), 5 * k, 0, 0.0});
      const double u = d.u.at(4, 3);
      if (k != 5) CHECK(std::abs(u - (k == 4 ? kOffset_mm : 0.0)) < 1e-9);
      e -= u;
    }
    CHECK(std::abs(e + kOffset_mm) < 0.02);
  }
}

}  // namespace firn::control
