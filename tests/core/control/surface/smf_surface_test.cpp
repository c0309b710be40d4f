#include "core/control/surface/smf_surface.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/smf_line/smf_line.h"
#include "core/grid/random.h"

namespace firn::control {
namespace {

constexpr double kSmfInterval_mm = 1.2;

SurfaceOptions smf_options(double kp, double ki, double kd) {
  SurfaceOptions o;
  o.interval_mm = kSmfInterval_mm;
  o.version = SurfaceVersion::kValveFrequency;
  o.smf = {kp, ki, kd, 1000.0};
  return o;
}

GridSpec grid(int nx, int ny, double x0 = 0.0, double y0 = 0.0) { return {nx, ny, 1.0, 1.0, x0, y0}; }

Grid<std::uint8_t> all(const GridSpec& g, CellMaterial m = CellMaterial::kPart) {
  return Grid<std::uint8_t>(g, std::uint8_t(m));
}

HeightMap height_of(const HeightMap& error, double nominal_mm) {
  HeightMap h(error.spec);
  for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = nominal_mm - kSmfInterval_mm * error.cells[c];
  return h;
}

/// A controller's answer to errors in intervals at interval k (1-based).
SurfaceDecision answer(SurfaceController& s, const HeightMap& error, int k,
                       const Grid<std::uint8_t>& material, int attempt = 0) {
  const HeightMap h = height_of(error, k * kSmfInterval_mm);
  return s.decide({h, material, k * kSmfInterval_mm, 5 * k, attempt, 0.0});
}

}  // namespace

TEST_CASE(
    "(5.1), (5.2), (5.11a): on a constant grid every cell is the one-dimensional controller of smf_line") {
  const GridSpec g = grid(7, 5);
  for (const smf_line::Gains gains :
       {smf_line::Gains{1.0, 0.25, 0.25}, {0.9999, 0.32798, 0.00005}, {0.7, 0.4, 0.1}}) {
    SurfaceOptions o = smf_options(gains.kp, gains.ki_star, gains.kd_star);
    o.output_limit = 1.0;
    SmfSurface smf(o);
    const int n = 30;
    std::vector<std::vector<double>> d(g.size()), errors(g.size(), std::vector<double>(n)), actions = errors;
    for (std::size_t c = 0; c < g.size(); ++c) {
      for (int k = 0; k < n; ++k)
        d[c].push_back(0.1 *
                       (random_uniform({7, Purpose::kTest, 0, std::uint32_t(c), std::uint32_t(k)}) - 0.5));
      smf_line::simulate(gains, d[c], errors[c], actions[c]);
    }
    HeightMap e(g, 0.0);
    for (int k = 1; k <= n; ++k) {
      const SurfaceDecision decision = answer(smf, e, k, all(g));
      REQUIRE(decision.saturated_fraction == 0.0);
      for (std::size_t c = 0; c < g.size(); ++c) {
        REQUIRE(e.cells[c] == Approx(errors[c][std::size_t(k - 1)]).margin(1e-12));
        REQUIRE(decision.u.cells[c] == Approx(actions[c][std::size_t(k - 1)]).margin(1e-12));
        e.cells[c] -= decision.u.cells[c] + d[c][std::size_t(k - 1)];  // (5.16) as the errata have it
      }
    }
  }
}

TEST_CASE("(5.1): at k = 1 the derivative term is left out, the integral term is not") {
  SmfSurface smf(smf_options(0.5, 0.25, 10.0));
  const GridSpec g = grid(4, 4);
  CHECK(answer(smf, HeightMap(g, 0.2), 1, all(g)).u.at(1, 1) == Approx(0.5 * 0.2 + 0.25 * 0.2));
  CHECK(answer(smf, HeightMap(g, 0.21), 2, all(g)).u.at(1, 1) ==
        Approx(0.5 * 0.21 + 0.25 * 0.41 + 10.0 * 0.01));
}

TEST_CASE(
    "5.1.2: sum and last error follow the part onto a grid that moves and shrinks, and new cells start at "
    "zero") {
  SmfSurface smf(smf_options(0.5, 0.25, 0.5));
  const GridSpec first = grid(8, 6);
  HeightMap e(first);
  const auto plane = [](double x, double y) { return 0.02 + 0.01 * x - 0.005 * y; };
  for (int j = 0; j < first.ny; ++j)
    for (int i = 0; i < first.nx; ++i) e.at(i, j) = plane(first.x_mm(i), first.y_mm(j));
  answer(smf, e, 1, all(first));
  const GridSpec second = grid(6, 6, 3.25, 0.5);  // between the old cells in x and y, and beyond them
  const SurfaceDecision d = answer(smf, HeightMap(second, 0.1), 2, all(second));
  int old_cells = 0, new_cells = 0;
  for (int j = 0; j < second.ny; ++j)
    for (int i = 0; i < second.nx; ++i) {
      const double x = second.x_mm(i), y = second.y_mm(j);
      const bool old = x <= 7.0 && y <= 5.0;
      (old ? old_cells : new_cells) += 1;
      const double before = plane(x, y);  // bilinear resampling is exact on a plane
      CHECK(d.u.at(i, j) ==
            Approx(old ? 0.05 + 0.25 * (0.1 + before) + 0.5 * (0.1 - before) : 0.05 + 0.25 * 0.1));
    }
  CHECK(old_cells > 10);
  CHECK(new_cells > 10);
}

TEST_CASE("Cells that join the footprint inside an old grid start at zero, too") {
  SmfSurface smf(smf_options(0.5, 0.25, 0.5));
  const GridSpec g = grid(6, 4);
  Grid<std::uint8_t> half = all(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 3; i < g.nx; ++i) half.at(i, j) = 0;
  answer(smf, HeightMap(g, 0.2), 1, half);
  const SurfaceDecision d = answer(smf, HeightMap(g, 0.1), 2, all(g));
  CHECK(d.u.at(1, 1) == Approx(0.05 + 0.25 * 0.3 - 0.05));
  CHECK(d.u.at(4, 1) == Approx(0.05 + 0.25 * 0.1));
}

TEST_CASE("5.2.2: the saturated action keeps the path speed within 30 % of nominal") {
  SurfaceOptions o = smf_options(1.0, 0.25, 0.25);
  o.version = SurfaceVersion::kPathSpeed;
  const ActionBounds b = action_bounds(o);
  CHECK(speed_for(25.0, b.low) == Approx(1.3 * 25.0));
  CHECK(speed_for(25.0, b.high) == Approx(0.7 * 25.0));
  SmfSurface smf(o);
  const GridSpec g = grid(20, 1);
  HeightMap e(g);
  for (int i = 0; i < g.nx; ++i) e.at(i, 0) = -1.0 + 0.1 * i;
  const SurfaceDecision d = answer(smf, e, 1, all(g));
  int saturated = 0;
  for (int i = 0; i < g.nx; ++i) {
    const double wanted = 1.25 * e.at(i, 0), c = speed_for(25.0, d.u.at(i, 0));
    CHECK(c >= 0.7 * 25.0 * (1 - 1e-12));
    CHECK(c <= 1.3 * 25.0 * (1 + 1e-12));
    if (wanted > b.low && wanted < b.high)
      CHECK(d.u.at(i, 0) == Approx(wanted));
    else
      ++saturated;
  }
  CHECK(d.saturated_fraction == Approx(saturated / 20.0));
}

TEST_CASE(
    "5.2.2: the integral is held at its limit, so a subarea is not driven away once it is at its height") {
  SurfaceOptions held = smf_options(1.0, 0.25, 0.0), free = held;
  held.smf.integral_limit = 0.3;
  SmfSurface a(held), b(free);
  const GridSpec g = grid(3, 3);
  for (int k = 1; k <= 20; ++k) {
    answer(a, HeightMap(g, 0.9), k, all(g));
    answer(b, HeightMap(g, 0.9), k, all(g));
  }
  CHECK(a.integral().at(1, 1) == Approx(0.3 / 0.25));
  CHECK(answer(a, HeightMap(g, 0.0), 21, all(g)).u.at(1, 1) == Approx(0.3));
  CHECK(answer(b, HeightMap(g, 0.0), 21, all(g)).u.at(1, 1) ==
        Approx(1.0));  // saturated by the wound-up integral
}

TEST_CASE(
    "(5.7), (5.8) with errata: the speed is reciprocal in the saturated u', and (5.4) as printed, linear, is "
    "not that") {
  const double flow = 9.375, width = 1.5, height = 0.25;
  for (double u = -0.2; u <= 0.4; u += 0.1) {
    const double c = speed_for(25.0, u);
    CHECK(flow / ((u + 1.0) * width * height) == Approx(c));  // Q / ((u + 1) w dh_d)
    CHECK(flow / c == Approx((1.0 + u) * width * height));  // (5.3): the volume per length that was asked for
    if (std::abs(u) > 1e-9) CHECK(std::abs(25.0 * (1.0 + u) - c) > 1e-3);
  }
}

TEST_CASE("(5.10) with errata: durations scale with 1 + U', as speeds do with its inverse") {
  for (double u = -0.23; u <= 0.42; u += 0.05)
    CHECK(0.4 / speed_for(25.0, u) == Approx((1.0 + u) * (0.4 / 25.0)));
}

TEST_CASE("A second map of a layer replaces the first, in sum, difference and the count of saturated maps") {
  SurfaceOptions o = smf_options(1.0, 0.25, 0.25);
  o.stop_after = 3;
  SmfSurface twice(o), once(o);
  const GridSpec g = grid(3, 3);
  for (int k = 1; k <= 2; ++k) {
    answer(twice, HeightMap(g, 5.0), k, all(g));
    answer(twice, HeightMap(g, 0.1 * k), k, all(g), 1);
    answer(once, HeightMap(g, 0.1 * k), k, all(g));
  }
  const SurfaceDecision a = answer(twice, HeightMap(g, 0.05), 3, all(g)),
                        b = answer(once, HeightMap(g, 0.05), 3, all(g));
  CHECK(a.u == b.u);
  CHECK(a.kind == SurfaceDecision::Kind::kPrint);
}

TEST_CASE(
    "More than the share of one material at the upper bound for n maps running stops the print by name, and "
    "one map between does not") {
  SurfaceOptions o = smf_options(1.0, 0.0, 0.0);
  o.stop_after = 3;
  const GridSpec g = grid(8, 2);
  Grid<std::uint8_t> both = all(g);
  for (int j = 0; j < 2; ++j)
    for (int i = 6; i < 8; ++i) both.at(i, j) = std::uint8_t(CellMaterial::kScaffold);
  HeightMap short_of_scaffold(g, 0.0);
  for (int j = 0; j < 2; ++j)
    for (int i = 6; i < 8; ++i) short_of_scaffold.at(i, j) = 2.0;
  SmfSurface smf(o);
  for (const int k : {1, 2})
    CHECK(answer(smf, short_of_scaffold, k, both).kind == SurfaceDecision::Kind::kPrint);
  CHECK(answer(smf, HeightMap(g, 0.0), 3, both).kind == SurfaceDecision::Kind::kPrint);
  for (const int k : {4, 5})
    CHECK(answer(smf, short_of_scaffold, k, both).kind == SurfaceDecision::Kind::kPrint);
  const SurfaceDecision d = answer(smf, short_of_scaffold, 6, both);
  CHECK(d.kind == SurfaceDecision::Kind::kStop);
  CHECK(d.reason.find("the scaffold asks for all the material") != std::string::npos);
}

TEST_CASE(
    "Feed-forward divides the flow by what the valve gives, per material, and the statistics are those of "
    "the map") {
  SurfaceOptions o = smf_options(1.0, 0.0, 0.0);
  o.feed_forward = true;
  SmfSurface smf(o);
  smf.use_flow({1.25, 0.8});
  const GridSpec g = grid(2, 1);
  Grid<std::uint8_t> both = all(g);
  both.at(1, 0) = std::uint8_t(CellMaterial::kScaffold);
  const SurfaceDecision d = answer(smf, HeightMap(g, 0.1), 1, both);
  CHECK(1.25 * (1.0 + d.u.at(0, 0)) == Approx(1.1));
  CHECK(0.8 * (1.0 + d.u.at(1, 0)) == Approx(1.1));
  CHECK(d.feed_forward[0] == Approx(0.8));
  CHECK(d.rms_mm == Approx(0.12));
  CHECK(d.mean_error_mm == Approx(-0.12));
  CHECK_THROWS_WITH(smf.use_flow({0.0, 1.0}), Catch::Contains("must be above 0"));
}

TEST_CASE("Beyond the footprint the action goes on for two cells and is then zero") {
  SmfSurface smf(smf_options(1.0, 0.0, 0.0));
  const GridSpec g = grid(9, 1);
  Grid<std::uint8_t> one(g);
  one.at(4, 0) = 1;
  HeightMap e(g, kNotMeasured);
  e.at(4, 0) = 0.3;
  const SurfaceDecision d = answer(smf, e, 1, one);
  for (int i = 0; i < 9; ++i) CHECK(d.u.at(i, 0) == Approx(std::abs(i - 4) <= 2 ? 0.3 : 0.0).margin(1e-15));
}

TEST_CASE("What cannot be used is refused by name, and the last layer ends the print") {
  SurfaceOptions o = smf_options(1.0, 0.25, 0.25);
  o.last_layer = 10;
  const GridSpec g = grid(3, 2);
  SmfSurface smf(o);
  CHECK(answer(smf, HeightMap(g, 0.0), 2, all(g)).kind == SurfaceDecision::Kind::kEnd);
  CHECK_THROWS_WITH(answer(smf, HeightMap(g, 0.0), 1, all(g)), Catch::Contains("layer 5 after layer 10"));
  CHECK_THROWS_WITH(answer(smf, HeightMap(g, kNotMeasured), 3, all(g)), Catch::Contains("cell (0, 0)"));
  CHECK_THROWS_WITH(answer(smf, HeightMap(g, 0.0), 3, Grid<std::uint8_t>(g)),
                    Catch::Contains("no footprint"));
  CHECK_THROWS_WITH(answer(smf, HeightMap(g, 0.0), 3, all(grid(2, 2))),
                    Catch::Contains("not on the same grid"));
  SurfaceOptions bad = o;
  bad.scheme = "pid";
  CHECK_THROWS_WITH(make_surface_controller(bad), Catch::Contains("open_loop, smf, smf_adaptive"));
  bad = o;
  bad.speed_range = 1.0;
  CHECK_THROWS_WITH(make_surface_controller(bad), Catch::Contains("speed_range"));
  bad = o;
  bad.smf.ki_star = -0.1;
  CHECK_THROWS_WITH(make_surface_controller(bad), Catch::Contains("ki_star"));
}

TEST_CASE("Open loop corrects nothing and still tells the error") {
  SurfaceOptions o = smf_options(1.0, 0.25, 0.25);
  o.scheme = "open_loop";
  const auto s = make_surface_controller(o);
  const GridSpec g = grid(3, 2);
  const SurfaceDecision d = answer(*s, HeightMap(g, 0.5), 1, all(g));
  CHECK(d.u == HeightMap(g, 0.0));
  CHECK(d.rms_mm == Approx(0.6));
}

}  // namespace firn::control
