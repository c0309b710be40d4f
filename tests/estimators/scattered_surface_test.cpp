#include "estimators/surface/scattered_surface.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

namespace firn::surface {
namespace {

std::vector<SurfacePoint> scattered(std::uint64_t seed, int n, double size_mm) {
  RandomStream random(seed, Purpose::kTest);
  std::vector<SurfacePoint> p;
  for (int k = 0; k < n; ++k)
    p.push_back(
        {random.uniform(-size_mm, size_mm), random.uniform(-size_mm, size_mm), random.uniform(-1.0, 1.0)});
  return p;
}

/// Andrew's monotone chain.
std::vector<SurfacePoint> hull_of(std::vector<SurfacePoint> p) {
  std::sort(p.begin(), p.end(), [](const auto& a, const auto& b) {
    return a.x_mm != b.x_mm ? a.x_mm < b.x_mm : a.y_mm < b.y_mm;
  });
  const auto turn = [](const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
    return (b.x_mm - a.x_mm) * (c.y_mm - a.y_mm) - (b.y_mm - a.y_mm) * (c.x_mm - a.x_mm);
  };
  std::vector<SurfacePoint> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t base = hull.size();
    for (const SurfacePoint& q : p) {
      while (hull.size() >= base + 2 && turn(hull[hull.size() - 2], hull.back(), q) <= 0) hull.pop_back();
      hull.push_back(q);
    }
    hull.pop_back();
    std::reverse(p.begin(), p.end());
  }
  return hull;
}

/// Distance inside (> 0) or outside (< 0) of the convex hull.
double depth(const std::vector<SurfacePoint>& hull, double x, double y) {
  double least = 1e9;
  for (std::size_t n = 0; n < hull.size(); ++n) {
    const SurfacePoint &a = hull[n], &b = hull[(n + 1) % hull.size()];
    const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm;
    least = std::min(least, (dx * (y - a.y_mm) - dy * (x - a.x_mm)) / std::sqrt(dx * dx + dy * dy));
  }
  return least;
}

}  // namespace

TEST_CASE(
    "A plane through scattered points is reproduced everywhere inside their hull, and there is nothing "
    "outside it") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::vector<SurfacePoint> p = scattered(seed, 2000, 60.0);
    const auto plane = [](double x, double y) { return 3.0 + 0.01 * x - 0.02 * y; };
    for (SurfacePoint& q : p) q.z_mm = plane(q.x_mm, q.y_mm);
    const std::vector<SurfacePoint> hull = hull_of(p);
    ScatteredSurface s(p);
    CHECK(s.points() == p.size());
    const HeightMap h = s.on({160, 160, 0.8, 0.8, -64.0, -64.0});
    for (int j = 0; j < 160; ++j)
      for (int i = 0; i < 160; ++i) {
        const double x = h.spec.x_mm(i), y = h.spec.y_mm(j), d = depth(hull, x, y);
        if (d > 1e-3) REQUIRE(h.at(i, j) == Approx(plane(x, y)).epsilon(0).margin(1e-9));
        if (d < -1e-4) REQUIRE(std::isnan(h.at(i, j)));
      }
  }
}

TEST_CASE(
    "The surface holds every point's height at the point, and between them stays within the points' range") {
  const std::vector<SurfacePoint> p = scattered(7, 3000, 50.0);
  ScatteredSurface s(p);
  for (const SurfacePoint& q : p) REQUIRE(s.at(q.x_mm, q.y_mm) == Approx(q.z_mm).margin(1e-4));
  const HeightMap h = s.on({200, 200, 0.5, 0.5, -50.0, -50.0});
  for (const double z : h.cells)
    if (std::isfinite(z)) REQUIRE(std::abs(z) <= 1.0 + 1e-9);
}

TEST_CASE(
    "The triangles are Delaunay's: the height equals that of the triangle whose circle holds no other "
    "point") {
  const std::vector<SurfacePoint> p = scattered(11, 40, 10.0);
  ScatteredSurface s(p);
  RandomStream random(12, Purpose::kTest);
  int checked = 0;
  for (int n = 0; n < 60; ++n) {
    const double x = random.uniform(-8, 8), y = random.uniform(-8, 8);
    for (std::size_t a = 0; a < p.size(); ++a)
      for (std::size_t b = a + 1; b < p.size(); ++b)
        for (std::size_t c = b + 1; c < p.size(); ++c) {
          const double ux = p[b].x_mm - p[a].x_mm, uy = p[b].y_mm - p[a].y_mm, vx = p[c].x_mm - p[a].x_mm,
                       vy = p[c].y_mm - p[a].y_mm;
          const double area = ux * vy - uy * vx, wx = x - p[a].x_mm, wy = y - p[a].y_mm;
          const double t = (wx * vy - wy * vx) / area, r = (ux * wy - uy * wx) / area;
          if (!(t > 1e-6 && r > 1e-6 && t + r < 1.0 - 1e-6)) continue;
          const double u2 = ux * ux + uy * uy, v2 = vx * vx + vy * vy;
          const double cx = (vy * u2 - uy * v2) / (2 * area), cy = (ux * v2 - vx * u2) / (2 * area),
                       r2 = cx * cx + cy * cy;
          bool empty = true;
          for (std::size_t k = 0; k < p.size() && empty; ++k) {
            const double dx = p[k].x_mm - p[a].x_mm - cx, dy = p[k].y_mm - p[a].y_mm - cy;
            empty = k == a || k == b || k == c || dx * dx + dy * dy > r2 * (1 - 1e-9);
          }
          if (!empty) continue;
          ++checked;
          REQUIRE(s.at(x, y) ==
                  Approx(p[a].z_mm + t * (p[b].z_mm - p[a].z_mm) + r * (p[c].z_mm - p[a].z_mm)).margin(1e-4));
        }
  }
  CHECK(checked > 40);
}

TEST_CASE("Rows of equally spaced points, repeated and crossing ones, on lines and circles do not upset it") {
  std::vector<SurfacePoint> p;
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 200; ++i) p.push_back({0.5 * (j % 2 ? 199 - i : i), 2.0 * j, 0.001 * i});
  for (int k = 0; k < 2000; ++k)
    p.push_back({50 + 30 * std::cos(0.01 * k), 40 + 30 * std::sin(0.01 * k), 0.0});
  for (int k = 0; k < 300; ++k) p.push_back({0.5 * k, 0.0, 1.0});
  ScatteredSurface s(p);
  for (int i = 0; i < 199; ++i) CHECK(std::isfinite(s.at(0.5 * i + 0.25, 1.0)));
  CHECK(s.at(10.0, 0.0) == Approx(0.5 * (1.0 + 0.02)).margin(1e-6));  // twice there: the mean
}

TEST_CASE(
    "Fewer than three points, points on one line, and numbers that are not finite give no surface and no "
    "crash") {
  CHECK(std::isnan(ScatteredSurface(std::vector<SurfacePoint>{}).at(0, 0)));
  CHECK(std::isnan(ScatteredSurface(std::vector<SurfacePoint>{{0, 0, 1}, {1, 1, 1}}).at(0.2, 0.8)));
  std::vector<SurfacePoint> line;
  for (int k = 0; k < 50; ++k) line.push_back({0.1 * k, 0.0, 1.0});
  CHECK(std::isnan(ScatteredSurface(line).at(1.0, 0.5)));
  std::vector<SurfacePoint> holes = scattered(3, 100, 5.0);
  for (std::size_t k = 0; k < holes.size(); k += 5) holes[k].z_mm = kNotMeasured;
  CHECK(ScatteredSurface(holes).points() == 80);
  holes[1].x_mm = 1e6;
  CHECK_THROWS_WITH(ScatteredSurface(holes), Catch::Contains("10 m apart"));
}

TEST_CASE(
    "A cell's mean over equal parts is exact on planes, and nearer than its centre to the mean of a curved "
    "surface") {
  RandomStream random(11, Purpose::kTest);
  std::vector<SurfacePoint> plane, bowl;
  for (int n = 0; n < 20000; ++n) {
    const double x = -12.0 + 24.0 * random.uniform(), y = -12.0 + 24.0 * random.uniform();
    plane.push_back({x, y, 0.3 * x - 0.2 * y + 1.0});
    bowl.push_back({x, y, x * x + y * y});
  }
  const GridSpec g{8, 6, 2.0, 2.0, -7.0, -5.0};
  ScatteredSurface flat(plane), curved(bowl);
  const HeightMap mean = flat.on(g, 3), centre = curved.on(g), over = curved.on(g, 8);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      CHECK(mean.at(i, j) == Approx(0.3 * g.x_mm(i) - 0.2 * g.y_mm(j) + 1.0).margin(1e-6));
      const double truth = g.x_mm(i) * g.x_mm(i) + g.y_mm(j) * g.y_mm(j) + 2.0 * 4.0 / 12.0;
      CHECK(std::abs(over.at(i, j) - truth) < 0.1);
      CHECK(std::abs(over.at(i, j) - truth) < std::abs(centre.at(i, j) - truth));
    }
  CHECK_THROWS_AS(flat.on(g, 0), std::invalid_argument);
}

TEST_CASE("Cells without a value take their nearest one's") {
  HeightMap h({5, 1, 1, 1, 0, 0}, kNotMeasured);
  fill_from_nearest(h);
  CHECK(std::isnan(h.at(2, 0)));
  h.at(0, 0) = 1.0;
  h.at(4, 0) = 2.0;
  fill_from_nearest(h);
  CHECK(h.at(1, 0) == 1.0);
  CHECK(h.at(3, 0) == 2.0);
}

TEST_CASE(
    "Points in needles, where the triangulation's rounded search goes round in circles, are taken beside "
    "their place") {
  // Passes to and fro over one ring, some micrometres or less apart, as measurement paths of a thin wall have
  // them.
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    RandomStream random(seed, Purpose::kTest, 5);
    const double apart = std::pow(10.0, -6.0 + 4.0 * random.uniform());
    std::vector<SurfacePoint> points;
    for (int pass = 0; pass < 6; ++pass)
      for (int n = 0; n < 120; ++n) {
        const double along = (pass % 2 ? 119 - n : n) * 1.25 * (seed % 3 == 0 ? 0.01 : 1.0),
                     aside = apart * (pass + 0.3 * random.uniform());
        const double turn = seed % 4 == 0 ? 0.0 : 0.7;
        points.push_back({along * std::cos(turn) - aside * std::sin(turn),
                          along * std::sin(turn) + aside * std::cos(turn), 1.0 + 0.01 * along});
      }
    for (int n = 0; n < 60; ++n) points.push_back({-20.0 + 3.0 * n, 40.0 - n, 1.0});
    CAPTURE(seed);
    REQUIRE_NOTHROW(ScatteredSurface(points));
  }
}

}  // namespace firn::surface
