#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "core/geometry/planar.h"
#include "core/slice/mesh/path_filter.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;

namespace {

double from_segment(const geometry::Point& p, const geometry::Point& a, const geometry::Point& b) {
  const double ex = double(b.x) - a.x, ey = double(b.y) - a.y, l2 = ex * ex + ey * ey;
  const double t =
      l2 == 0 ? 0 : std::clamp(((double(p.x) - a.x) * ex + (double(p.y) - a.y) * ey) / l2, 0.0, 1.0);
  return std::hypot(p.x - (a.x + t * ex), p.y - (a.y + t * ey));
}

std::vector<geometry::Point> wavy(RandomStream& random, int n) {
  std::vector<geometry::Point> ring;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * M_PI * i / n, r = 200'000 * (1 + 0.3 * std::sin(5 * a)) + random.uniform(-400, 400);
    ring.push_back({std::int32_t(r * std::cos(a)), std::int32_t(r * std::sin(a))});
  }
  std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
  return ring;
}

}  // namespace

TEST_CASE(
    "A contour and what PATHFILTER makes of it lie within the chord tolerance of each other [Barnett, "
    "PATHFILTER]") {
  RandomStream random(21, Purpose::kTest);
  for (const double tolerance : {50.0, 500.0, 5'000.0}) {
    const std::vector<geometry::Point> ring = wavy(random, 3'000);
    geometry::Rings out;
    PathFilter(0.0, tolerance).append(ring, out);
    REQUIRE(out.size() == 1);
    CHECK(out.points.size() < ring.size() / (tolerance > 400.0 ? 10 : 1));
    CHECK(out[0][0] == ring[0]);
    const auto furthest = [](std::span<const geometry::Point> from, std::span<const geometry::Point> to) {
      double worst = 0;
      for (std::size_t i = 0; i < from.size(); ++i) {
        const geometry::Point &a = from[i], &b = from[i + 1 < from.size() ? i + 1 : 0];
        for (const double share : {0.0, 0.3, 0.7}) {
          const geometry::Point p{std::int32_t(a.x + share * (b.x - a.x)),
                                  std::int32_t(a.y + share * (b.y - a.y))};
          double nearest = 1e300;
          for (std::size_t k = 0; k < to.size(); ++k)
            nearest = std::min(nearest, from_segment(p, to[k], to[k + 1 < to.size() ? k + 1 : 0]));
          worst = std::max(worst, nearest);
        }
      }
      return worst;
    };
    CHECK(furthest(ring, out[0]) <= tolerance + 2);
    CHECK(furthest(out[0], ring) <= tolerance + 2);
  }
}

TEST_CASE("Tolerance 0 and spacing 0 keep every point") {
  RandomStream random(22, Purpose::kTest);
  const std::vector<geometry::Point> ring = wavy(random, 500);
  geometry::Rings out;
  PathFilter(0.0, 0.0).append(ring, out);
  CHECK(std::equal(ring.begin(), ring.end(), out.points.begin(), out.points.end()));
}

TEST_CASE("Points that stay are no closer than the minimum spacing [Barnett, 3.2: 0.4 mm]") {
  RandomStream random(23, Purpose::kTest);
  const std::vector<geometry::Point> ring = wavy(random, 5'000);
  geometry::Rings out;
  PathFilter(4'000.0, 0.0).append(ring, out);
  for (std::size_t k = 0; k < out.points.size(); ++k) {
    const geometry::Point &a = out.points[k], &b = out.points[(k + 1) % out.points.size()];
    CHECK(std::hypot(double(b.x) - a.x, double(b.y) - a.y) >= 4'000.0);
  }
  CHECK(out.points.size() > 300);
}

TEST_CASE("A ring that lies within the tolerance of a line vanishes") {
  geometry::Rings out;
  PathFilter(0.0, 500.0)
      .append(std::vector<geometry::Point>{{0, 0}, {10'000, 100}, {20'000, 0}, {10'000, 300}}, out);
  CHECK(out.empty());
}
