// Places where simplified outlines may bound other areas than their contours.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "core/slice/offset/cusp_corrector.h"
#include "tests/core/slice/oracles.h"

namespace firn::slice {
namespace {

constexpr double kSimplified = 200;

// A rough ring about the origin.
geometry::Rings blob(RandomStream& random) {
  std::vector<geometry::Point> ring;
  for (int i = 0; i < 700; ++i) {
    const double a = 2 * M_PI * i / 700, r = 80'000 * (1 + 0.4 * std::cos(3 * a)) + random.uniform(-100, 100);
    ring.push_back(geometry::to_point({r * std::cos(a), r * std::sin(a)}));
  }
  geometry::Rings rings;
  rings.add(ring);
  return rings;
}

}  // namespace

TEST_CASE("An uncertain place that is resolved depends on no contour that is not kept") {
  RandomStream random(91, Purpose::kTest);
  int resolved = 0, left = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const geometry::Rings contours = blob(random);
    CuspCorrector cusps;
    cusps.take(contours);
    cusps.begin(kSimplified, true);
    const double d = random.uniform(6'000, 40'000);
    const geometry::Vec at{random.uniform(-60'000, 60'000), random.uniform(-60'000, 60'000)};
    cusps.uncertain().add(at, d);
    cusps.uncertain().refine();
    const std::vector<char> kept = cusps.kept();
    const geometry::Vec place =
        at + geometry::Vec{random.uniform(-6'000, 6'000), random.uniform(-6'000, 6'000)};
    const double asked = d + random.uniform(-3'000, 3'000);
    if (!cusps.uncertain().resolved(place, asked)) {
      ++left;
      continue;
    }
    ++resolved;
    // All contours within the distance of the place and twice the simplification.
    bool all = true;
    for (std::size_t i = 0; i < contours.points.size(); ++i)
      if (length(to_vec(contours.points[i]) - place) <= asked + 2 * kSimplified) all = all && kept[i];
    CHECK(all);
  }
  CHECK(resolved > 20);
  CHECK(left > 20);
}

TEST_CASE("An uncertain place is listed once, and not again where the outline is kept") {
  UncertainTopology uncertain;
  uncertain.begin(kSimplified);
  uncertain.add({0, 0}, 10'000);
  CHECK(uncertain.any());
  CHECK(uncertain.resolved({100, 0}, 10'100));
  CHECK_FALSE(uncertain.resolved({0, 0}, 20'000));
  uncertain.refine();
  CHECK_FALSE(uncertain.any());
  uncertain.add({100, 0}, 10'000);
  CHECK_FALSE(uncertain.any());
  uncertain.forget();
  uncertain.add({100, 0}, 10'000);
  CHECK(uncertain.any());
}

TEST_CASE("Sides without a contour near by leave no uncertainty without a place") {
  geometry::Rings contours;
  const geometry::Point far[] = {{4'000'000, 0}, {4'100'000, 0}, {4'100'000, 100'000}};
  contours.add(far);
  CuspCorrector cusps;
  cusps.take(contours);
  cusps.begin(kSimplified, true);
  geometry::Vec cusp{0, 0};
  CHECK_FALSE(cusps.move(cusp, {{0, -15'000}, {1, 0}}, {{0, 15'000}, {-1, 0}}, 15'000));
  cusps.uncertain().refine();
  REQUIRE(cusps.uncertain().kept().size() == 1);
  CHECK(cusps.uncertain().kept()[0].at.x == 0);
}

TEST_CASE(
    "Sides that close or open beside a cusp by less than the simplification are uncertain, straight ones are "
    "not") {
  // Two walls 2 d apart to within the simplification, a narrow wedge whose half width is d at x = 0.
  const double d = 15'000, slope = 0.01;
  const auto uncertain_near = [&](double bump, double at_x) {
    geometry::Rings contours;
    std::vector<geometry::Point> ring;
    const auto half = [&](double x) {
      return d - slope * x + bump * std::exp(-(x - at_x) * (x - at_x) / 4e6);
    };
    for (int x = -60'000; x <= 60'000; x += 500) ring.push_back(geometry::to_point({double(x), -half(x)}));
    for (int x = 60'000; x >= -60'000; x -= 500) ring.push_back(geometry::to_point({double(x), half(x)}));
    contours.add(ring);
    CuspCorrector cusps;
    cusps.take(contours);
    cusps.begin(kSimplified, true);
    // The lower wall leads into the cusp, the upper one out of it.
    const geometry::Vec into{1, slope}, out{-1, slope};
    geometry::Vec cusp{0, 0};
    CHECK(cusps.move(cusp, {{0, -d}, (1 / length(into)) * into}, {{0, d}, (1 / length(out)) * out}, d));
    CHECK(std::abs(cusp.x) < 1'500);
    return cusps.uncertain().any();
  };
  CHECK_FALSE(uncertain_near(0, 0));
  CHECK(uncertain_near(150, 10'000));    // beyond the cusp an opening
  CHECK(uncertain_near(-150, -10'000));  // before it a closure
  CHECK_FALSE(uncertain_near(-150, 10'000));
  CHECK_FALSE(uncertain_near(150, -10'000));
}

}  // namespace firn::slice
