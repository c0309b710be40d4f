#include "core/deposition/valve.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/deposition/flow_demand.h"
#include "tests/core/deposition/demands.h"

using namespace firn;
using namespace firn::deposition;

TEST_CASE("A monotone curve goes through its points, stays between neighbours and never falls") {
  RandomStream random(61, Purpose::kTest);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<MonotoneCurve::Point> points{{random.uniform(-5, 5), random.uniform(-5, 5)}};
    for (std::uint32_t n = 1 + random.below(20); n > 0; --n) {
      const double steep = random.below(4) == 0 ? 100.0 : 1.0;
      points.push_back(
          {points.back().x + random.uniform(1e-3, 2.0), points.back().y + steep * random.uniform(1e-3, 1.0)});
    }
    const MonotoneCurve curve(points);
    double before = points.front().y;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      REQUIRE(curve.at(points[i].x) == Approx(points[i].y).margin(1e-12));
      for (int k = 1; k <= 50; ++k) {
        const double x = points[i].x + (points[i + 1].x - points[i].x) * k / 50.0, y = curve.at(x);
        REQUIRE(y >= before - 1e-12);
        REQUIRE(y >= points[i].y - 1e-12);
        REQUIRE(y <= points[i + 1].y + 1e-12);
        REQUIRE(curve.inverse(y) == Approx(x).margin(1e-7));
        before = y;
      }
    }
    CHECK(curve.at(points.front().x - 1.0) == points.front().y);
    CHECK(curve.at(points.back().x + 1.0) == points.back().y);
  }
}

TEST_CASE("A monotone curve reproduces a straight line and reports a bad table by its row") {
  const MonotoneCurve line({{0, 1}, {1, 3}, {4, 9}, {5, 11}});
  for (double x = 0.0; x <= 5.0; x += 0.01) CHECK(line.at(x) == Approx(1.0 + 2.0 * x).epsilon(1e-14));
  CHECK_THROWS_WITH(MonotoneCurve({{0, 0}}), Catch::Contains("at least two points"));
  CHECK_THROWS_WITH(MonotoneCurve({{0, 0}, {1, 2}, {2, 2}}),
                    Catch::Contains("row 3") && Catch::Contains("ascend"));
  CHECK_THROWS_WITH(MonotoneCurve({{0, 0}, {1, std::numeric_limits<double>::quiet_NaN()}}),
                    Catch::Contains("row 2"));
}

TEST_CASE("Eq. (6.4): h gives each calibrated row back, starts at the origin and inverts") {
  const FlowCurve curve({{50, 11.0}, {100, 24.0}, {200, 52.0}, {400, 100.0}});
  for (const auto& [f, q] : {std::pair{50.0, 11.0}, {100.0, 24.0}, {200.0, 52.0}, {400.0, 100.0}}) {
    CHECK(curve.frequency_hz(q) == Approx(f).epsilon(1e-13));
    CHECK(curve.flow_mm3_s(f) == Approx(q).epsilon(1e-12));
  }
  CHECK(curve.frequency_hz(0.0) == 0.0);
  CHECK(curve.drop_mm3(0.0) == Approx(0.22));
  CHECK(curve.drop_mm3(1e-9) == Approx(0.22));
  CHECK(curve.drop_mm3(52.0) == Approx(0.26));
  CHECK_THROWS_AS(FlowCurve({}), std::invalid_argument);
}

TEST_CASE("Erratum chapter 6: C_f = c_ff c w dh = 37.5 Hz for the simulations of 5.7") {
  const FlowCurve curve = FlowCurve::proportional(deposition::test::kFeedForward, 500.0);
  const std::vector<double> speed{25.0};
  std::vector<double> flow(1);
  nominal_flow(deposition::test::kBoundary_mm, deposition::test::kLayer_mm, speed, flow);
  CHECK(curve.frequency_hz(flow[0]) == Approx(37.5).epsilon(1e-14));
}

TEST_CASE(
    "The highest frequency is one pulse per pulse width, per tick, of the valve or of the table, whichever "
    "is lowest") {
  const ValveLimits limits;
  const auto setting = [](double pulse_s, double table_hz) {
    return ValveSetting{pulse_s, FlowCurve::proportional(4.0, table_hz)};
  };
  CHECK(max_frequency_hz(setting(0.002, 1000.0), limits) == 500.0);
  CHECK(max_frequency_hz(setting(0.0005, 1000.0), limits) == 500.0);  // the 2 ms tick
  CHECK(max_frequency_hz(setting(0.008, 1000.0), limits) == 125.0);
  CHECK(max_frequency_hz(setting(0.001, 300.0), limits) == 300.0);
  ValveLimits fine;
  fine.tick_s = 0.0005;
  fine.max_duration_s = 32.0;
  CHECK(max_frequency_hz(setting(0.0005, 3000.0), fine) == 1000.0);
}

TEST_CASE("Table 2-2: no setting gives more than 200 uL/s") {
  const ValveLimits limits;
  const ValveSetting wide{0.002, FlowCurve::proportional(2.0, 500.0)};  // 250 mm^3/s by its table
  CHECK(max_flow_mm3_s(wide, limits) == 200.0);
  CHECK(max_flow_mm3_s({0.00125, FlowCurve::proportional(4.0, 500.0)}, limits) == Approx(125.0));
}

TEST_CASE("A pulse below 0.5 ms and a list of more than 65,536 ticks are refused by name") {
  CHECK_THROWS_WITH(check(ValveSetting{0.0004, FlowCurve::proportional(4.0, 500.0)}, ValveLimits{}),
                    Catch::Contains("minimum"));
  CHECK_NOTHROW(check(ValveSetting{0.0005, FlowCurve::proportional(4.0, 500.0)}, ValveLimits{}));
  CHECK_NOTHROW(check(ValveLimits{}));
  ValveLimits limits;
  limits.max_duration_s = 140.0;
  CHECK_THROWS_WITH(check(limits), Catch::Contains("65,536"));
}

TEST_CASE("Eqs. (6.2), (6.3): flow is w dh c (1 + u), and none below u = -1") {
  const std::vector<double> speed{0.0, 10.0, 125.0, 125.0, 125.0}, u{0.3, 0.0, 0.5, -0.5, -1.2};
  std::vector<double> nominal(5), corrected(5);
  nominal_flow(1.5, 0.25, speed, nominal);
  CHECK(nominal == std::vector<double>{0.0, 3.75, 46.875, 46.875, 46.875});
  corrected_flow(nominal, u, corrected);
  CHECK(corrected == std::vector<double>{0.0, 3.75, 70.3125, 23.4375, 0.0});
}

TEST_CASE(
    "The control action surface is read bilinearly, and outside it and beside unmeasured cells there is no "
    "correction") {
  HeightMap a(GridSpec{4, 3, 2.0, 1.0, 10.0, 20.0});
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i) a.at(i, j) = 0.1 * i + 0.05 * j;
  RandomStream random(62, Purpose::kTest);
  for (int n = 0; n < 200; ++n) {  // a plane is reproduced exactly
    const double x = random.uniform(0, 3), y = random.uniform(0, 2);
    CHECK(action_at(a, {10.0 + 2.0 * x, 20.0 + y}) == Approx(0.1 * x + 0.05 * y).margin(1e-12));
  }
  CHECK(action_at(a, {16.0, 22.0}) == Approx(0.4));
  CHECK(action_at(a, {9.99, 21.0}) == 0.0);
  CHECK(action_at(a, {12.0, 22.01}) == 0.0);
  CHECK(action_at(a, {std::numeric_limits<double>::quiet_NaN(), 21.0}) == 0.0);
  a.at(1, 1) = kNotMeasured;
  CHECK(action_at(a, {11.0, 20.5}) == 0.0);
  HeightMap single(GridSpec{1, 1, 1.0, 1.0, 0.0, 0.0}, 0.25);
  CHECK(action_at(single, {0.0, 0.0}) == 0.25);
}
