#include "estimators/flow/flow_estimator.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/planner.h"
#include "estimators/flow/laid_volume.h"

namespace firn::flow {
namespace {

const GridSpec kGrid{84, 70, 1.0, 1.0, -42.0, -35.0};

/// Ice in the middle, scaffold round it; a fifth of the blocks' volume varies from place to place.
FlowInterval interval(int k, double factor_a, double factor_b, double noise_mm, std::uint64_t seed) {
  FlowInterval f{5 * k, HeightMap(kGrid), {HeightMap(kGrid), HeightMap(kGrid)}};
  RandomStream random(seed, Purpose::kTest, std::uint32_t(k));
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) {
      const double x = kGrid.x_mm(i), y = kGrid.y_mm(j), r = std::sqrt(x * x + y * y);
      const std::size_t c = kGrid.index(i, j);
      const double wanted = 1.2 * (1.0 + 0.1 * std::sin(0.1 * x * k) + 0.1 * random.uniform());
      if (r < 26.0)
        f.nominal_mm[0].cells[c] = wanted;
      else if (r < 34.0)
        f.nominal_mm[1].cells[c] = wanted;
      f.rise_mm.cells[c] = factor_a * f.nominal_mm[0].cells[c] + factor_b * f.nominal_mm[1].cells[c] +
                           noise_mm * random.normal();
      if (random.uniform() < 0.0005) f.rise_mm.cells[c] += 30.0;  // debris
    }
  return f;
}

/// Beads 1.5 mm apart, ice in a ring of scaffold as wide as its buffer. Liquid falls on the beads' middles
/// and spreads over three cells; two fifths of the outer half of the last bead flow over the rim, and between
/// the materials every third cell is not known.
FlowInterval narrow_ring(double factor_a, double factor_b, std::uint64_t seed) {
  FlowInterval f{5, HeightMap(kGrid, 0.0), {HeightMap(kGrid, 0.0), HeightMap(kGrid, 0.0)}};
  RandomStream random(seed, Purpose::kTest);
  for (double r = 0.75; r < 31.3; r += 1.5) {
    const int drops = int(60 * r);
    for (int k = 0; k < drops; ++k) {
      const double angle = 2.0 * M_PI * k / drops, height = 1.2 * 1.5 * 2.0 * M_PI * r / drops;
      const int i = int(std::floor(r * std::cos(angle) + 42.5)),
                j = int(std::floor(r * std::sin(angle) + 35.5));
      const std::size_t valve = r < 28.0 ? 0 : 1;
      f.nominal_mm[valve].at(i, j) += height;
      for (int y = j - 1; y <= j + 1; ++y)
        for (int x = i - 1; x <= i + 1; ++x)
          f.rise_mm.at(x, y) += (valve ? factor_b : factor_a) * height / 9.0;
    }
  }
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) {
      const double r = std::hypot(kGrid.x_mm(i), kGrid.y_mm(j));
      double& rise = f.rise_mm.at(i, j);
      rise = (r > 30.75 ? 0.6 : 1.0) * rise + 0.1 * random.normal();
      if (std::abs(r - 28.0) < 1.5 && random.uniform() < 0.33) rise = kNotMeasured;
    }
  return f;
}

}  // namespace

TEST_CASE(
    "The factor of each valve is found from one interval, and its standard deviation covers the error") {
  int covered = 0, cases = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const double a = random.uniform(0.8, 1.2), b = random.uniform(0.8, 1.2);
    FlowEstimator e({});
    e.add(interval(1, a, b, 0.2, seed));
    const FlowEstimate& f = e.estimate();
    CHECK(f.factor[0] == Approx(a).epsilon(0.02));
    CHECK(f.factor[1] == Approx(b).epsilon(0.03));
    for (int v = 0; v < 2; ++v) {
      ++cases;
      covered += std::abs(f.factor[std::size_t(v)] - (v ? b : a)) < 1.96 * f.factor_std[std::size_t(v)];
    }
  }
  CHECK(covered >= 0.88 * cases);
  CHECK(covered < cases);
}

TEST_CASE(
    "A ring of scaffold narrower than a block tells the factor of its valve, whatever flows over its rim") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomStream random(seed, Purpose::kTest, 1);
    const double a = random.uniform(0.8, 1.2), b = random.uniform(0.8, 1.2);
    FlowEstimator e({});
    e.add(narrow_ring(a, b, seed));
    CHECK(e.estimate().factor[0] == Approx(a).margin(0.02));
    CHECK(e.estimate().factor[1] == Approx(b).margin(0.04));
    CHECK(e.estimate().factor_std[1] < 0.04);
  }
}

TEST_CASE("A drift of either sign is followed, and told per layer") {
  for (const double drift : {-0.2, 0.2}) {
    FlowEstimator e({});
    for (int k = 1; k <= 20; ++k)
      e.add(interval(k, 1.0 + drift * k / 20.0, 1.0 - 0.5 * drift * k / 20.0, 0.15, 3));
    const FlowEstimate& f = e.estimate();
    CHECK(f.factor[0] == Approx(1.0 + drift).margin(0.01));
    CHECK(f.factor[1] == Approx(1.0 - 0.5 * drift).margin(0.015));
    CHECK(f.drift_per_layer[0] == Approx(drift / 100.0).margin(0.0005));
    CHECK(f.drift_per_layer[1] == Approx(-0.5 * drift / 100.0).margin(0.0007));
    CHECK(f.intervals == 12);
    CHECK(f.evaluations <= 20 * 300);
  }
}

TEST_CASE("A blocked line shows as a factor near zero within two intervals") {
  FlowEstimator e({});
  for (int k = 1; k <= 4; ++k) e.add(interval(k, 1.0, 1.0, 0.1, 5));
  FlowOptions quick;
  quick.memory_layers = 5.0;
  FlowEstimator forgets(quick);
  for (int k = 1; k <= 4; ++k) forgets.add(interval(k, 1.0, 1.0, 0.1, 5));
  for (int k = 5; k <= 6; ++k) {
    e.add(interval(k, 0.0, 1.0, 0.1, 5));
    forgets.add(interval(k, 0.0, 1.0, 0.1, 5));
  }
  CHECK(e.estimate().factor[0] < 0.7);
  CHECK(forgets.estimate().factor[0] < 0.5);
  CHECK(e.estimate().factor[1] == Approx(1.0).margin(0.02));
}

TEST_CASE("Cells that are not known do not count") {
  FlowInterval holes = interval(1, 1.1, 0.9, 0.1, 9);
  RandomStream random(1, Purpose::kTest);
  for (double& rise : holes.rise_mm.cells)
    if (random.uniform() < 0.3) rise = kNotMeasured;
  FlowEstimator e({});
  e.add(holes);
  CHECK(e.estimate().factor[0] == Approx(1.1).margin(0.01));
  CHECK(e.estimate().factor[1] == Approx(0.9).margin(0.02));
}

TEST_CASE("Squares of 49 cells tell something from seven known ones on, and nothing below") {
  for (const int known : {6, 7}) {
    FlowInterval few = interval(1, 1.1, 0.9, 0.1, 9);
    for (int j = 0; j < kGrid.ny; ++j)
      for (int i = 0; i < kGrid.nx; ++i)
        if (i % 7 + 7 * (j % 7) >= known) few.rise_mm.at(i, j) = kNotMeasured;
    FlowEstimator e({});
    e.add(few);
    INFO(known << " cells known");
    CHECK((e.estimate().factor[0] == 1.0) == (known == 6));
    CHECK((e.estimate().factor_std[0] == Approx(0.2)) == (known == 6));
  }
}

TEST_CASE("A map measured again replaces the first, and wrong input is refused by name") {
  FlowEstimator once({}), twice({});
  once.add(interval(1, 1.1, 0.9, 0.1, 7));
  twice.add(interval(1, 2.0, 2.0, 0.1, 8));
  twice.add(interval(1, 1.1, 0.9, 0.1, 7));
  CHECK(twice.estimate().factor[0] == Approx(once.estimate().factor[0]).epsilon(1e-4));
  FlowInterval other = interval(3, 1, 1, 0.1, 9);
  other.nominal_mm[1].spec.nx = 10;
  CHECK_THROWS_WITH(once.add(other), Catch::Contains("different grids"));
  CHECK_THROWS_WITH(twice.add(interval(0, 1, 1, 0.1, 9)), Catch::Contains("layer 0 after layer 5"));
  FlowOptions bad;
  bad.prior_std = 0.0;
  CHECK_THROWS_WITH(FlowEstimator(bad), Catch::Contains("prior_std"));
}

TEST_CASE("Laid volume stands where the nozzle was when the pulses arrived, and none is lost on the grid") {
  const auto arm = motion::make_scara(motion::cobra600());
  const motion::Tool nozzle = motion::cobra600_tools()[1];
  const std::vector<Point2> line{{-30.0, 0.0}, {30.0, 0.0}};
  motion::PathInput in;
  in.points = line;
  in.origin = {354.0, -46.0};
  in.tool = nozzle;
  in.speed_limit.path_mm_s = 40.0;
  const motion::PlanResult r = motion::plan(in, *arm, motion::cobra600_limits());
  REQUIRE(r.ok());
  std::vector<std::int32_t> ticks;
  for (std::int32_t k = 0; k < std::int32_t(r.trajectory.certificate.duration_s / 0.002); k += 10)
    ticks.push_back(k);
  for (const double latency : {0.0, -0.03, 0.05}) {
    HeightMap laid({84, 70, 1.0, 1.0, -42.0, -35.0});
    add_laid({r.trajectory, 0.0, 0.002, latency, 25.0, ticks}, {*arm, nozzle, in.origin}, laid);
    double volume = 0.0, middle = 0.0, row = 0.0;
    for (int j = 0; j < 70; ++j)
      for (int i = 0; i < 84; ++i) {
        volume += laid.at(i, j);
        middle += laid.at(i, j) * laid.spec.x_mm(i);
        if (j == 35) row += laid.at(i, j);
      }
    CHECK(volume == Approx(25.0));
    CHECK(row == Approx(25.0));
    CHECK(middle / volume == Approx(40.0 * latency).margin(0.55));
  }
}

}  // namespace firn::flow
