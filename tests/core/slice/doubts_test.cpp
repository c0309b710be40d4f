// Where thinned outlines may bound other areas than their contours.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "core/slice/offset/exact_tips.h"
#include "tests/core/slice/oracles.h"

namespace firn::slice {
namespace {

constexpr double kThinned = 200;

// A rough ring about the origin.
Rings blob(RandomStream& random) {
  std::vector<Point> ring;
  for (int i = 0; i < 700; ++i) {
    const double a = 2 * M_PI * i / 700, r = 80'000 * (1 + 0.4 * std::cos(3 * a)) + random.uniform(-100, 100);
    ring.push_back(to_point({r * std::cos(a), r * std::sin(a)}));
  }
  Rings rings;
  rings.add(ring);
  return rings;
}

}  // namespace

TEST_CASE("A doubt that is settled depends on no contour that is not kept") {
  RandomStream random(91, Purpose::kTest);
  int settled = 0, left = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Rings contours = blob(random);
    ExactTips tips;
    tips.take(contours);
    tips.begin(kThinned, true);
    const double d = random.uniform(6'000, 40'000);
    const Vec at{random.uniform(-60'000, 60'000), random.uniform(-60'000, 60'000)};
    tips.doubts().add(at, d);
    tips.doubts().keep();
    const std::vector<char> kept = tips.kept();
    const Vec place = at + Vec{random.uniform(-6'000, 6'000), random.uniform(-6'000, 6'000)};
    const double asked = d + random.uniform(-3'000, 3'000);
    if (!tips.doubts().settled(place, asked)) {
      ++left;
      continue;
    }
    ++settled;
    // Whatever the place's distance from the contours has to do with, and twice the thinning around it.
    bool all = true;
    for (std::size_t i = 0; i < contours.points.size(); ++i)
      if (length(to_vec(contours.points[i]) - place) <= asked + 2 * kThinned) all = all && kept[i];
    CHECK(all);
  }
  CHECK(settled > 20);
  CHECK(left > 20);
}

TEST_CASE("A doubt is listed once, and not again where the outline is kept") {
  Doubts doubts;
  doubts.begin(kThinned);
  doubts.add({0, 0}, 10'000);
  CHECK(doubts.any());
  CHECK(doubts.settled({100, 0}, 10'100));
  CHECK_FALSE(doubts.settled({0, 0}, 20'000));
  doubts.keep();
  CHECK_FALSE(doubts.any());
  doubts.add({100, 0}, 10'000);
  CHECK_FALSE(doubts.any());
  doubts.forget();
  doubts.add({100, 0}, 10'000);
  CHECK(doubts.any());
}

TEST_CASE("Walls without a contour near by leave no doubt that has no place") {
  Rings contours;
  const Point far[] = {{4'000'000, 0}, {4'100'000, 0}, {4'100'000, 100'000}};
  contours.add(far);
  ExactTips tips;
  tips.take(contours);
  tips.begin(kThinned, true);
  Vec tip{0, 0};
  CHECK_FALSE(tips.move(tip, {{0, -15'000}, {1, 0}}, {{0, 15'000}, {-1, 0}}, 15'000));
  tips.doubts().keep();
  REQUIRE(tips.doubts().kept().size() == 1);
  CHECK(tips.doubts().kept()[0].at.x == 0);
}

TEST_CASE(
    "Walls that close or open beside a tip by less than the thinning are in doubt, straight ones are not") {
  // Two walls 2 d apart to within the thinning, a narrow wedge whose half width is d at x = 0.
  const double d = 15'000, slope = 0.01;
  const auto doubts_of = [&](double bump, double at_x) {
    Rings contours;
    std::vector<Point> ring;
    const auto half = [&](double x) {
      return d - slope * x + bump * std::exp(-(x - at_x) * (x - at_x) / 4e6);
    };
    for (int x = -60'000; x <= 60'000; x += 500) ring.push_back(to_point({double(x), -half(x)}));
    for (int x = 60'000; x >= -60'000; x -= 500) ring.push_back(to_point({double(x), half(x)}));
    contours.add(ring);
    ExactTips tips;
    tips.take(contours);
    tips.begin(kThinned, true);
    // The lower wall leads into the tip, the upper one out of it.
    const Vec into{1, slope}, out{-1, slope};
    Vec tip{0, 0};
    CHECK(tips.move(tip, {{0, -d}, (1 / length(into)) * into}, {{0, d}, (1 / length(out)) * out}, d));
    CHECK(std::abs(tip.x) < 1'500);
    return tips.doubts().any();
  };
  CHECK_FALSE(doubts_of(0, 0));
  CHECK(doubts_of(150, 10'000));    // beyond the tip an opening
  CHECK(doubts_of(-150, -10'000));  // before it a closure
  CHECK_FALSE(doubts_of(-150, 10'000));
  CHECK_FALSE(doubts_of(150, -10'000));
}

}  // namespace firn::slice
