#include "core/motion/constant_speed.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/thesis/test_path.h"

using namespace firn;
using namespace firn::motion;

namespace {

double duration(const Trajectory& t) { return double(t.samples() - 1) * t.tick_s; }

std::vector<double> speeds(const Trajectory& t) {
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < t.samples(); ++i)
    out.push_back(std::hypot(t.positions[2 * i + 2] - t.positions[2 * i],
                             t.positions[2 * i + 3] - t.positions[2 * i + 1]) /
                  t.tick_s);
  return out;
}

std::unique_ptr<Arm> stage() { return make_stage({{{-500, 500}, {-500, 500}}}); }

}  // namespace

TEST_CASE("4.2: the boundary of Fig. 4-2 at 25 mm/s takes its length over the speed, and the ramps") {
  const auto path = thesis::fig_4_2();
  const PathInput in{.points = path};
  const Trajectory t = plan_constant(in, *stage(), cobra600_limits());
  CHECK(duration(t) == Approx(14.119114857512855 + 25.0 / 500).margin(0.017));
  int at_speed = 0;
  for (const double c : speeds(t)) {
    CHECK(c <= 25 * (1 + 1e-9));
    at_speed += c > 24.8;
  }
  CHECK(at_speed > 0.95 * double(t.samples()));  // also through the sharp corner
}

TEST_CASE("Straight fill goes at its own speed and stops at each end of a line") {
  std::vector<Point2> zigzag;
  for (int i = 0; i < 6; ++i) {
    zigzag.push_back({i % 2 ? 80.0 : 0.0, 3.0 * i});
    zigzag.push_back({i % 2 ? 0.0 : 80.0, 3.0 * i});
  }
  PathInput in{.points = zigzag};
  in.kind = PathKind::kFill;
  const Trajectory t = plan_constant(in, *stage(), cobra600_limits());
  int stops = 0;
  double top = 0;
  const auto c = speeds(t);
  for (std::size_t i = 1; i + 1 < c.size(); ++i) {
    stops += c[i] < c[i - 1] && c[i] <= c[i + 1] && c[i] < 10;
    top = std::max(top, c[i]);
  }
  CHECK(stops == 10);
  CHECK(top <= 100 * (1 + 1e-9));
  CHECK(top > 99);
  ConstantOptions faster;
  faster.fill_mm_s = 125;
  CHECK(duration(plan_constant(in, *stage(), cobra600_limits(), faster)) < duration(t));
}

TEST_CASE(
    "4.4: fill along contours is driven at the boundaries' speed, since only straight fill is safe at more") {
  const auto path = thesis::fig_4_2();
  PathInput in{.points = path};
  const double boundary = duration(plan_constant(in, *stage(), cobra600_limits()));
  in.kind = PathKind::kFill;
  CHECK(duration(plan_constant(in, *stage(), cobra600_limits())) == boundary);
  CHECK(fill_stops(path, PathKind::kFill, 0.5).size() == 2);
  const std::vector<Point2> lines{{0, 0}, {10, 0}, {20, 0}, {20, 10}};
  CHECK(fill_stops(lines, PathKind::kFill, 0.5) == std::vector<std::size_t>{0, 2, 3});
  CHECK(fill_stops(lines, PathKind::kBoundary, 0.5) == std::vector<std::size_t>{0, 3});
}

TEST_CASE("The ramped speed covers its length under random speed limits and never exceeds them or the ramp") {
  RandomStream random(61, Purpose::kTest);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> s{0.0}, speed_limit;
    for (std::uint32_t i = 0; i < 1 + random.below(20); ++i) {
      s.push_back(s.back() + std::exp(random.uniform(-6, 3)));
      speed_limit.push_back(std::exp(random.uniform(0, 5)));
    }
    const RampedSpeed law(s, speed_limit, 500);
    REQUIRE(law.distance_at(law.duration_s()) == Approx(s.back()).epsilon(1e-9));
    const double h = law.duration_s() / 500;
    double before = 0, speed = 0;
    for (int k = 1; k <= 500; ++k) {
      const double here = law.distance_at(k * h), c = (here - before) / h;
      REQUIRE(here >= before - 1e-12);
      REQUIRE(std::abs(c - speed) <= 500 * h * (1 + 1e-6) + 1e-9);
      std::size_t i = 0;
      while (i + 1 < speed_limit.size() && s[i + 1] <= before) ++i;
      double allowed = 0;
      for (std::size_t m = i; m < speed_limit.size() && s[m] <= here; ++m)
        allowed = std::max(allowed, speed_limit[m]);
      REQUIRE(c <= allowed * (1 + 1e-6) + 1e-9);
      before = here;
      speed = c;
    }
  }
}

TEST_CASE("A speed limit lowers the constant speed where it holds") {
  const std::vector<Point2> line{{0, 0}, {50, 0}, {100, 0}};
  PathInput in{.points = line};
  in.speed_limit.point_mm_s = {25, 25, 5};
  const auto c = speeds(plan_constant(in, *stage(), cobra600_limits()));
  CHECK(c[c.size() / 20] == Approx(25).margin(0.2));
  CHECK(c[c.size() * 3 / 4] == Approx(5).margin(0.1));
}

TEST_CASE("Speeds and ramps that are not positive are refused by name") {
  const std::vector<Point2> line{{0, 0}, {50, 0}};
  const PathInput in{.points = line};
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    ConstantOptions options;
    options.boundary_mm_s = bad;
    CHECK_THROWS_WITH(plan_constant(in, *stage(), cobra600_limits(), options),
                      Catch::Contains("boundary speed"));
    options = {};
    options.ramp_mm_s2 = bad;
    CHECK_THROWS_WITH(plan_constant(in, *stage(), cobra600_limits(), options), Catch::Contains("ramp"));
  }
}
