#include "core/control/controller.h"

#include <catch2/catch.hpp>

#include "core/control/prediction.h"
#include "core/grid/random.h"
#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;

TEST_CASE("The table names the schemes, and an unknown scheme is answered with the known ones") {
  const Setup s = cylinder_setup();
  ControlOptions o;
  for (const Scheme& scheme : schemes()) {
    o.scheme = scheme.name;
    o.registration.spacing_cells = 4;  // room for marks on these small parts
    CHECK(make_controller(s, o) != nullptr);
  }
  o.scheme = "pdi";
  CHECK_THROWS_WITH(make_controller(s, o),
                    Catch::Contains("'pdi'") && Catch::Contains("open_loop, smf, threshold, mpc"));
}

TEST_CASE("A setup with an empty mask, a bad target or other sizes is refused by name") {
  Setup s = cylinder_setup();
  CHECK_NOTHROW(check(s));
  Setup empty = s;
  empty.mask = Mask(s.grid);
  CHECK_THROWS_WITH(check(empty), Catch::Contains("mask"));
  Setup nan = s;
  nan.target.at(20, 21) = kNotMeasured;
  CHECK_THROWS_WITH(check(nan), Catch::Contains("cell (20, 21)"));
  Setup small = s;
  small.target = HeightMap(GridSpec{3, 3});
  CHECK_THROWS_WITH(check(small), Catch::Contains("9 cells"));
}

TEST_CASE(
    "NaN outside the mask is the bare substrate, and NaN on it, another grid or a negative layer is an "
    "error, "
    "for every scheme") {
  const Setup s = cylinder_setup();
  HeightMap holes(s.grid, 0.1), zeros(s.grid, 0.1);
  for (std::size_t c = 0; c < holes.size(); ++c)
    if (!s.mask.cells[c]) {
      holes.cells[c] = kNotMeasured;
      zeros.cells[c] = 0.0;
    }
  HeightMap bad = zeros;
  bad.at(20, 20) = kNotMeasured;
  HeightMap moved = zeros;
  moved.spec.origin_x_mm = 1.0;
  for (const Scheme& scheme : schemes()) {
    ControlOptions o;
    o.scheme = scheme.name;
    o.registration.spacing_cells = 4;  // room for marks on these small parts
    CHECK(make_controller(s, o)->decide({holes, 3, 0, 0.0}).drops ==
          make_controller(s, o)->decide({zeros, 3, 0, 0.0}).drops);
    CHECK_THROWS_WITH(make_controller(s, o)->decide({bad, 3, 0, 0.0}), Catch::Contains("cell (20, 20)"));
    CHECK_THROWS_WITH(make_controller(s, o)->decide({moved, 3, 0, 0.0}), Catch::Contains("grid"));
    CHECK_THROWS_WITH(make_controller(s, o)->decide({zeros, -1, 0, 0.0}), Catch::Contains("layer -1"));
  }
}

TEST_CASE("Every scheme: droplets only on the mask, decisions repeat exactly, and the print ends") {
  Setup s = cylinder_setup(21.0, 0.06);
  for (const Scheme& scheme : schemes()) {
    ControlOptions o;
    o.scheme = scheme.name;
    o.registration.spacing_cells = 4;  // room for marks on these small parts
    const LoopConditions q{0.2, 0.001, 0.002, 5, 60};
    const auto a = make_controller(s, o), b = make_controller(s, o);
    const LoopResult ra = run_loop(*a, s, q), rb = run_loop(*b, s, q);
    CHECK(ra.ended);
    REQUIRE(ra.decisions.size() == rb.decisions.size());
    for (std::size_t n = 0; n < ra.decisions.size(); ++n) {
      CHECK(ra.decisions[n].drops == rb.decisions[n].drops);
      CHECK(ra.decisions[n].objective_mm == rb.decisions[n].objective_mm);
      CHECK_FALSE(ra.decisions[n].reason.empty());
      for (std::size_t c = 0; c < s.grid.size(); ++c)
        if (!s.mask.cells[c]) REQUIRE(ra.decisions[n].drops.cells[c] == 0);
    }
    CHECK(ra.height == rb.height);
  }
}

TEST_CASE("Feedback brings a varied cylinder to its height, open loop does not") {
  const Setup s = cylinder_setup();
  const auto rms_um = [&](const char* scheme) {
    ControlOptions o;
    o.scheme = scheme;
    const auto controller = make_controller(s, o);
    const LoopResult r = run_loop(*controller, s, {0.2, 0.001, 0.0, 9, 120});
    CHECK(r.ended);
    return 1e3 * r.stats.rms_mm;
  };
  CHECK(rms_um("open_loop") > 30.0);
  CHECK(rms_um("smf") < 3.0);
  CHECK(rms_um("mpc") < 2.5);
}

TEST_CASE("max_layers stops for the operator, not silently") {
  const Setup s = cylinder_setup();
  ControlOptions o;
  o.scheme = "mpc";
  o.max_layers = 3;
  const auto controller = make_controller(s, o);
  const LoopResult r = run_loop(*controller, s, {});
  CHECK(r.layers == 3);
  CHECK(r.decisions.back().kind == Decision::Kind::kStop);
  CHECK(r.decisions.back().drops.total() == 0);
  CHECK_THAT(r.decisions.back().reason, Catch::Contains("max_layers = 3"));
  o.max_layers = -1;
  CHECK_THROWS_WITH(make_controller(s, o), Catch::Contains("max_layers"));
  o.max_layers = 3;
  o.noise_gate = -1.0;
  CHECK_THROWS_WITH(make_controller(s, o), Catch::Contains("noise_gate"));
}

TEST_CASE("Erratum (8): the objective takes a matrix h_d, and mean and deviation run over the mask") {
  const GridSpec g{3, 2};
  HeightMap h(g), target(g);
  Mask mask(g, 1);
  for (std::size_t c = 0; c < 6; ++c) {
    h.cells[c] = double(c);
    target.cells[c] = 2.0 * double(c);
  }
  mask.at(2, 1) = 0;
  // heights 0 1 2 3 4, errors 0 1 2 3 4
  CHECK(objective_mm(h, target, mask, 1.0) == Approx(2.0));
  CHECK(objective_mm(h, target, mask, 0.0) == Approx(std::sqrt(2.0)));
  CHECK(objective_mm(h, target, mask, 0.25) == Approx(0.25 * 2.0 + 0.75 * std::sqrt(2.0)));
}

TEST_CASE("the spread term of (8) is std(H) for a flat target, and does not punish the shape of any other") {
  const GridSpec grid{6, 5, 0.2, 0.2, 0.0, 0.0};
  RandomStream random(5, Purpose::kTest);
  HeightMap height(grid), slope(grid), on_slope(grid);
  for (std::size_t c = 0; c < grid.size(); ++c) {
    height.cells[c] = random.uniform();
    slope.cells[c] = 3.0 * double(c);
    on_slope.cells[c] = slope.cells[c] + height.cells[c];
  }
  const Mask all(grid, 1);
  const ErrorStats s = error_stats(height, HeightMap(grid, 0.0), all);
  CHECK(objective_mm(height, HeightMap(grid, 7.0), all, 0.0) == Approx(s.std_mm));
  CHECK(objective_mm(on_slope, slope, all, 0.0) == Approx(s.std_mm));
}
