#include "core/motion/vplus_default.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/thesis/test_path.h"

using namespace firn;
using namespace firn::motion;

namespace {

std::unique_ptr<Arm> moving_stage() { return make_stage({{{-500, 500}, {-500, 500}}}); }
double duration_s(const Trajectory& t) { return double(t.samples() - 1) * t.tick_s; }
Point2 at(const Trajectory& t, std::size_t i) { return {t.positions[2 * i], t.positions[2 * i + 1]}; }

}  // namespace

TEST_CASE("4.4: a right corner at 125 mm/s is rounded as by a radius of 10 mm (FIT of the blend time)") {
  const std::vector<Point2> corner{{0, 0}, {100, 0}, {100, 100}};
  const Trajectory t = plan_default({.points = corner}, *moving_stage(), cobra600_limits());
  double first = 0, nearest = 1e9;  // where the motion leaves the line; how near it comes to the corner
  for (std::size_t i = 0; i < t.samples(); ++i) {
    if (at(t, i).y_mm < 1e-9) first = at(t, i).x_mm;
    nearest = std::min(nearest, std::hypot(at(t, i).x_mm - 100, at(t, i).y_mm));
  }
  CHECK(100 - first == Approx(125 * 0.16 / 2).margin(125 * 0.016));
  CHECK(nearest == Approx(std::sqrt(2.0) * 125 * 0.16 / 8).margin(0.2));
}

TEST_CASE(
    "4.4: on closely spaced points the speed is their spacing over the blend time, whatever is commanded") {
  for (const double spacing : {1.0, 2.0, 5.0}) {
    std::vector<Point2> arc;
    for (double a = 0; a < 3.0; a += spacing / 40) arc.push_back({40 * std::cos(a), 40 * std::sin(a)});
    DefaultOptions options;
    options.support_spacing_mm = 0;
    const Trajectory t = plan_default({.points = arc}, *moving_stage(), cobra600_limits(), options);
    const std::size_t k = t.samples() / 2;
    const double speed =
        std::hypot(at(t, k + 1).x_mm - at(t, k).x_mm, at(t, k + 1).y_mm - at(t, k).y_mm) / t.tick_s;
    CHECK(speed == Approx(spacing / 0.16).epsilon(0.03));
  }
}

TEST_CASE("The path of Fig. 4-2 is given to V+ as ends, corners and points on the rounds") {
  const auto points = thesis::fig_4_2();
  const CleanPath path = clean({.points = points});
  const auto support = supporting_points(path, 3.5);
  CHECK(support.front() == 0);
  CHECK(support.back() == points.size() - 1);
  CHECK(support.size() > 15);
  CHECK(support.size() < 30);
  double longest = 0;
  int corners = 0;
  for (std::size_t k = 1; k < support.size(); ++k) {
    const Point2 a = path.points[support[k - 1]], b = path.points[support[k]];
    longest = std::max(longest, std::hypot(b.x_mm - a.x_mm, b.y_mm - a.y_mm));
    corners += std::hypot(b.x_mm, b.y_mm) < 1e-6;
  }
  CHECK(longest > 80);  // the straight sides are one move
  CHECK(corners == 1);
}

TEST_CASE("The blend time is found with which the default technique takes a given time") {
  const auto points = thesis::fig_4_2();
  const PathInput in{.points = points};
  DefaultOptions options;
  options.blend_s = blend_for_duration(in, cobra600_limits(), options, 6.0);
  CHECK(duration_s(plan_default(in, *moving_stage(), cobra600_limits(), options)) ==
        Approx(6.0).margin(0.017));
  CHECK_THROWS_AS(blend_for_duration(in, cobra600_limits(), options, 1.0), MotionError);
}

TEST_CASE("Random paths are followed from the first point to the last within the speed limit") {
  RandomStream random(71, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Point2> points{{0, 0}};
    for (std::uint32_t i = 0; i < 1 + random.below(20); ++i)
      points.push_back(
          {random.uniform(-300, 300), random.below(5) ? random.uniform(-300, 300) : points.back().y_mm});
    PathInput in{.points = points};
    in.speed_limit.path_mm_s = random.uniform(5, 200);
    const Trajectory t = plan_default(in, *moving_stage(), cobra600_limits());
    REQUIRE(at(t, 0) == points.front());
    REQUIRE(at(t, t.samples() - 1) == points.back());
    for (std::size_t i = 0; i + 1 < t.samples(); ++i) {
      const double ds = std::hypot(at(t, i + 1).x_mm - at(t, i).x_mm, at(t, i + 1).y_mm - at(t, i).y_mm);
      REQUIRE(ds <= std::min(125.0, in.speed_limit.path_mm_s) * t.tick_s * (1 + 1e-9));
    }
  }
}

TEST_CASE("Default options that cannot be are refused by name") {
  const std::vector<Point2> line{{0, 0}, {50, 0}};
  DefaultOptions options;
  options.blend_s = 0;
  CHECK_THROWS_WITH(plan_default({.points = line}, *moving_stage(), cobra600_limits(), options),
                    Catch::Contains("blend time"));
  options = {};
  options.support_spacing_mm = NAN;
  CHECK_THROWS_WITH(plan_default({.points = line}, *moving_stage(), cobra600_limits(), options),
                    Catch::Contains("support"));
}
