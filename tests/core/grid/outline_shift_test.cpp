// The shift of a deposit against its outline, from maps with planted shifts, noise and lost cells.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/outline_shift.h"
#include "core/grid/random.h"

using namespace firn;

namespace {

// A lens with a notch: no symmetry.
double part(double x_mm, double y_mm) {
  const bool in = std::hypot(x_mm, 1.4 * y_mm) < 6.0 && !(x_mm > 1.0 && std::abs(y_mm - 1.0) < 0.8);
  return in ? 1.0 : 0.0;
}

// Mean over a cell, as a sensor's cell and a bead's edge blur it.
double blurred(double x_mm, double y_mm, double pitch_mm) {
  double sum = 0.0;
  for (int a = 0; a < 5; ++a)
    for (int b = 0; b < 5; ++b) sum += part(x_mm + (a - 2) * pitch_mm / 5, y_mm + (b - 2) * pitch_mm / 5);
  return sum / 25.0;
}

Mask laid_on(const GridSpec& g) {
  Mask laid(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) laid.at(i, j) = part(g.x_mm(i), g.y_mm(j)) > 0.5;
  return laid;
}

}  // namespace

TEST_CASE("A planted shift is found within a third of a cell, under noise and with cells lost") {
  RandomStream random(3, Purpose::kTest);
  const auto normal = [&] {
    double sum = -6.0;
    for (int n = 0; n < 12; ++n) sum += random.uniform();
    return sum;
  };
  const GridSpec g{33, 29, 0.5, 0.5, -8.0, -7.0};
  const Mask laid = laid_on(g);
  for (int trial = 0; trial < 40; ++trial) {
    const double sx = trial == 0 ? 0.0 : 4.0 * (random.uniform() - 0.5),
                 sy = trial == 0 ? 0.0 : 4.0 * (random.uniform() - 0.5);
    HeightMap rise(g);
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i)
        rise.at(i, j) = random.uniform() < 0.1
                            ? kNotMeasured
                            : 1.2 * blurred(g.x_mm(i) - sx, g.y_mm(j) - sy, 0.5) + 0.1 * normal();
    const OutlineShift s = outline_shift(rise, laid, {}, 3.0);
    CAPTURE(trial, sx, sy, s.x_mm, s.y_mm);
    REQUIRE(s.known);
    CHECK(std::abs(s.x_mm - sx) < 0.17);
    CHECK(std::abs(s.y_mm - sy) < 0.17);
    CHECK(s.rise_mm == Approx(1.2).epsilon(0.1));
  }
}

TEST_CASE("Readings on the part alone show a shift too, as a strip along one edge that did not rise") {
  const GridSpec g{33, 29, 0.5, 0.5, -8.0, -7.0};
  const Mask laid = laid_on(g);
  for (const double sx : {0.0, 2.0, -2.0}) {
    HeightMap rise(g, kNotMeasured);
    for (std::size_t c = 0; c < g.size(); ++c)
      if (laid.cells[c]) rise.cells[c] = blurred(g.x_mm(int(c) % g.nx) - sx, g.y_mm(int(c) / g.nx), 0.5);
    const OutlineShift s = outline_shift(rise, laid, {}, 3.0);
    REQUIRE(s.known == (sx != 0.0));  // without a cell that did not rise there is no edge to compare
    CHECK(s.x_mm == Approx(sx).margin(0.3));
    CHECK(s.y_mm == Approx(0.0).margin(0.3));
  }
}

TEST_CASE("Nothing laid, nothing measured or noise alone tells no shift") {
  const GridSpec g{33, 29, 0.5, 0.5, -8.0, -7.0};
  CHECK_FALSE(outline_shift(HeightMap(g, 1.0), Mask(g), {}, 2.0).known);
  CHECK_FALSE(outline_shift(HeightMap(g, kNotMeasured), laid_on(g), {}, 2.0).known);
  CHECK_FALSE(outline_shift(HeightMap(g, 0.0), laid_on(g), {}, 2.0).known);
  CHECK_THROWS_AS(outline_shift(HeightMap(GridSpec{2, 2}), laid_on(g), {}, 2.0), std::invalid_argument);
}

TEST_CASE("A shift of one material shows where it leaves its place and where it lies on the other") {
  const GridSpec g{30, 30, 1.0, 1.0, -14.5, -14.5};
  Mask part(g), scaffold(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double r = std::max(std::abs(g.x_mm(i)), std::abs(g.y_mm(j)));
      part.at(i, j) = r < 10.0;
      scaffold.at(i, j) = r > 10.0 && r < 12.6;
    }
  for (const auto& [sx, sy] :
       {std::pair{2.0, 0.0}, std::pair{-2.0, 0.0}, std::pair{0.0, 2.0}, std::pair{0.0, 0.0}}) {
    HeightMap rise(g, kNotMeasured);
    for (std::size_t c = 0; c < g.size(); ++c) {
      if (!part.cells[c] && !scaffold.cells[c]) continue;
      const int i = int(c) % g.nx - int(sx), j = int(c) / g.nx - int(sy);
      rise.cells[c] = (g.contains(i, j) && part.at(i, j) ? 1.2 : 0.0) + (scaffold.cells[c] ? 1.1 : 0.0);
    }
    const OutlineShift a = outline_shift(rise, part, scaffold, 4.0),
                       b = outline_shift(rise, scaffold, part, 4.0);
    REQUIRE(a.known);
    CHECK(a.x_mm == Approx(sx).margin(0.3));
    CHECK(a.y_mm == Approx(sy).margin(0.3));
    if (sx != 0.0 || sy != 0.0) CHECK(a.gain > 0.6);
    CHECK(b.gain < a.gain + 1e-9);
  }
}

TEST_CASE("An edge that did not rise shows how far the readings reach beyond the deposit") {
  const GridSpec g{33, 29, 0.5, 0.5, -8.0, -7.0};
  const Mask laid = laid_on(g);
  for (const double share : {0.0, 0.3, 0.8}) {
    HeightMap rise(g, kNotMeasured);
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i)
        if (laid.at(i, j)) rise.at(i, j) = i + 1 < g.nx && laid.at(i + 1, j) ? 1.0 : 1.0 - share;
    const EdgeGap gap = edge_gap(rise);
    REQUIRE(gap.known);
    CHECK(gap.x_mm == Approx(0.5 * share).epsilon(0.1).margin(1e-9));
    CHECK(std::abs(gap.y_mm) < 0.05);
  }
  CHECK_FALSE(edge_gap(HeightMap(g, kNotMeasured)).known);
}
