// Widths of edges and radii of corners against closed forms.
#include "core/grid/edge_profile.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "core/grid/outline.h"
#include "core/grid/random.h"

using namespace firn;

namespace {

constexpr double kTop_mm = 0.4;
constexpr GridSpec kEdgeGrid{81, 81, 0.1, 0.1, -4.0, -4.0};

// A part of all cells whose signed distance to the outline, by `inside_mm`, is above 0.
struct Part {
  HeightMap target;
  Mask mask;
  Part(const GridSpec& g, const std::function<double(double, double)>& inside_mm) : target(g, 0.0), mask(g) {
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i)
        if (inside_mm(g.x_mm(i), g.y_mm(j)) > 0.0) {
          mask.at(i, j) = 1;
          target.at(i, j) = kTop_mm;
        }
  }
};

// Flanks that fall linearly from top to ground over `flank_mm`, half way on the outline.
HeightMap flanked(const GridSpec& g, double flank_mm,
                  const std::function<double(double, double)>& inside_mm) {
  HeightMap h(g, 0.0);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      h.at(i, j) = kTop_mm * std::clamp(0.5 + inside_mm(g.x_mm(i), g.y_mm(j)) / flank_mm, 0.0, 1.0);
  return h;
}

double in_disc(double x, double y, double radius) { return radius - std::hypot(x, y); }

// Distance to the sides of a square with rounded corners, positive inside.
double in_rounded(double x, double y, double half, double radius) {
  const double u = std::abs(x) - (half - radius), v = std::abs(y) - (half - radius);
  if (u > 0.0 && v > 0.0) return radius - std::hypot(u, v);
  return radius - std::max(u, v);
}

}  // namespace

TEST_CASE("The edge of a cone frustum is four fifths of its flank wide, on any grid and radius") {
  for (const GridSpec& g : {kEdgeGrid, GridSpec{121, 81, 0.07, 0.1, -4.2, -4.0}})
    for (const double radius : {2.0, 2.83})
      for (const double flank : {0.6, 1.1, 2.0}) {
        const auto disc = [&](double x, double y) { return in_disc(x, y, radius); };
        const Part part(g, disc);
        CHECK(edge_width_mm(flanked(g, flank, disc), part.target, part.mask) ==
              Approx(0.8 * flank).epsilon(0.01));
      }
}

TEST_CASE("An edge keeps its width where the part is wider than its target") {
  const Part part(kEdgeGrid, [](double x, double y) { return in_disc(x, y, 2.0); });
  const HeightMap wide = flanked(kEdgeGrid, 0.8, [](double x, double y) { return in_disc(x, y, 2.4); });
  CHECK(edge_width_mm(wide, part.target, part.mask) == Approx(0.64).epsilon(0.01));
}

TEST_CASE("A box whose sides fall from one cell to the next has an edge of 0.8 pitches") {
  const Part box(kEdgeGrid, [](double x, double y) { return 2.05 - std::max(std::abs(x), std::abs(y)); });
  CHECK(edge_width_mm(box.target, box.target, box.mask) == Approx(0.08).epsilon(0.02));
}

TEST_CASE("A hole's edge counts as the outer one does") {
  const auto ring = [](double x, double y) { return std::min(in_disc(x, y, 3.0), -in_disc(x, y, 1.2)); };
  const Part part(kEdgeGrid, ring);
  CHECK(edge_width_mm(flanked(kEdgeGrid, 0.7, ring), part.target, part.mask) == Approx(0.56).epsilon(0.01));
}

TEST_CASE("An edge that begins at the map's border is as wide as its mirror images") {
  const GridSpec g{24, 24, 0.1, 0.1, 0.0, 0.0};
  RandomStream random(3, Purpose::kTest);
  HeightMap height(g, 0.0);
  for (double& h : height.cells) h = random.uniform(0.0, 1.3 * kTop_mm);
  const auto width = [&](bool swap, bool flip_x, bool flip_y) {
    HeightMap target(g, 0.0), turned(g, 0.0);
    Mask mask(g);
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        int a = flip_x ? g.nx - 1 - i : i, b = flip_y ? g.ny - 1 - j : j;
        if (swap) std::swap(a, b);
        turned.at(a, b) = height.at(i, j);
        if (i < 4 || i > 19 || j > 15) continue;  // it touches the first row
        mask.at(a, b) = 1;
        target.at(a, b) = kTop_mm;
      }
    return edge_width_mm(turned, target, mask);
  };
  const double plain = width(false, false, false);
  CHECK(plain > 0.0);
  for (int n = 1; n < 8; ++n) CHECK(width(n & 1, n & 2, n & 4) == Approx(plain).epsilon(1e-9));
}

TEST_CASE("A part that has not reached its height has no edge") {
  const auto disc = [](double x, double y) { return in_disc(x, y, 2.0); };
  const Part part(kEdgeGrid, disc);
  HeightMap low = flanked(kEdgeGrid, 0.8, disc);
  for (double& h : low.cells) h *= 0.6;
  CHECK(std::isnan(edge_width_mm(low, part.target, part.mask)));
}

TEST_CASE("A rounded corner's radius is found, also of a part that is too wide") {
  const Part box(kEdgeGrid, [](double x, double y) { return 2.05 - std::max(std::abs(x), std::abs(y)); });
  for (const double half : {2.05, 2.4})
    for (const double radius : {0.4, 0.7, 1.0}) {
      const HeightMap h =
          flanked(kEdgeGrid, 0.3, [&](double x, double y) { return in_rounded(x, y, half, radius); });
      CHECK(corner_radius_mm(h, box.target, box.mask) == Approx(radius).epsilon(0.04));
    }
}

TEST_CASE("A corner between cells reads half a diagonal of a cell over sqrt(2) - 1 short of two thirds") {
  const Part box(kEdgeGrid, [](double x, double y) { return 2.05 - std::max(std::abs(x), std::abs(y)); });
  // On the bisector the surface between four cells is (1 - s)^2 from the corner's cell: half at 1 -
  // sqrt(0.5).
  const double from_corner = 0.5 - (1.0 - std::sqrt(0.5));
  CHECK(corner_radius_mm(box.target, box.target, box.mask) ==
        Approx(0.1 * from_corner * std::sqrt(2.0) / (std::sqrt(2.0) - 1.0)).epsilon(0.02));
}

TEST_CASE("A disc has no corner, in its own cells and in finer ones") {
  const Part disc(kEdgeGrid, [](double x, double y) { return in_disc(x, y, 3.0); });
  CHECK(std::isnan(corner_radius_mm(disc.target, disc.target, disc.mask)));
  GridSpec fine{243, 243, 0.1 / 3, 0.1 / 3, -4.0 - 0.1 / 3, -4.0 - 0.1 / 3};
  HeightMap height(fine, 0.0);
  for (int j = 0; j < fine.ny; ++j)
    for (int i = 0; i < fine.nx; ++i) height.at(i, j) = disc.target.at(i / 3, j / 3);
  CHECK(std::isnan(outline_stats(disc.target, disc.target, disc.mask, &height).corner_radius_mm));
}

TEST_CASE("Edge and corner of a fine map are those of the surface, not of its means over cells") {
  const auto square = [](double x, double y) { return in_rounded(x, y, 2.1, 0.5); };
  GridSpec coarse{41, 41, 0.2, 0.2, -4.0, -4.0}, fine{205, 205, 0.04, 0.04, -4.08, -4.08};
  const Part box(coarse, [](double x, double y) { return 2.1 - std::max(std::abs(x), std::abs(y)); });
  const HeightMap sharp = flanked(fine, 0.2, square);
  HeightMap means(coarse, 0.0);
  for (int j = 0; j < fine.ny; ++j)
    for (int i = 0; i < fine.nx; ++i) means.at(i / 5, j / 5) += sharp.at(i, j) / 25.0;
  const OutlineStats s = outline_stats(means, box.target, box.mask, &sharp);
  CHECK(s.edge_width_mm == Approx(0.16).epsilon(0.05));
  CHECK(s.corner_radius_mm == Approx(0.5).epsilon(0.04));
  CHECK(outline_stats(means, box.target, box.mask).edge_width_mm > 0.18);
  const HeightMap other(GridSpec{100, 100, 0.04, 0.04, 0.0, 0.0}, 0.0);
  CHECK_THROWS_WITH(outline_stats(means, box.target, box.mask, &other), Catch::Contains("fine map"));
}
