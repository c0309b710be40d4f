// The methods that know only their samples, behind the one door of all planners.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/curve/deviation.h"
#include "core/motion/planner.h"
#include "core/motion/sampled_trace.h"
#include "core/motion/thesis/test_path.h"

using namespace firn;
using namespace firn::motion;

namespace {

PlanResult plan_fig_4_2(Method method, PathKind kind = PathKind::kBoundary) {
  const auto points = thesis::fig_4_2();
  PathInput in{.points = points};
  in.origin = thesis::kWellPlaced;
  in.kind = kind;
  PlanOptions options;
  options.method = method;
  options.trace_step_s = 0.001;
  return plan(in, *make_scara(cobra600()), cobra600_limits(), options);
}

double ratio(const PlanResult& r, const std::string& limit) {
  for (const LimitRatio& l : r.trajectory.certificate.limits)
    if (l.limit == limit) return l.ratio;
  FAIL("no such limit: " << limit);
  return 0;
}

}  // namespace

TEST_CASE("4.3: the checker finds the thesis method's jerk violations and says how large they are") {
  const PlanResult r = plan_fig_4_2(Method::kThesis);
  REQUIRE(r.ok());
  CHECK(ratio(r, "total jerk") > 1.3);
  CHECK(ratio(r, "total jerk") < 3.5);
  CHECK(ratio(r, "total speed") <= 1.001);
  CHECK(ratio(r, "total acceleration") < 1.1);
  CHECK(r.trajectory.certificate.limits.size() == 9);
  CHECK(r.stops == 1);
  CHECK(r.deviation_mm < 0.02);
  CHECK(r.trajectory.certificate.lower_bound_s <= 3.7251);       // velocity and acceleration alone
  CHECK(r.trajectory.certificate.lower_bound_s > 3.725 * 0.99);  // its grid costs less than a hundredth
  CHECK(plan_fig_4_2(Method::kDefault).trajectory.certificate.lower_bound_s == 0);  // it cuts the corner
}

TEST_CASE(
    "The default technique's certificate shows its rounded corner, the constant speed's its corner at "
    "speed") {
  const PlanResult rounded = plan_fig_4_2(Method::kDefault), constant = plan_fig_4_2(Method::kConstant);
  CHECK(rounded.deviation_mm > 2);
  CHECK(rounded.deviation_mm < 4);
  CHECK(rounded.stops == 0);
  CHECK(constant.deviation_mm < 1e-6);
  CHECK(ratio(constant, "total jerk") > 5);
  CHECK(constant.stops == 0);
}

TEST_CASE("4.4: straight fill at 125 mm/s by constant speed takes L / v + v / a, as at 100") {
  const std::vector<Point2> line{{300, 0}, {400, 0}};
  PathInput in{.points = line};
  in.kind = PathKind::kFill;
  PlanOptions options;
  options.method = Method::kConstant;
  for (const double speed : {100.0, 125.0}) {
    options.constant_fill_mm_s = speed;
    const PlanResult r = plan(in, *make_scara(cobra600()), cobra600_limits(), options);
    REQUIRE(r.ok());
    CHECK(r.continuous_s == Approx(100.0 / speed + speed / 500.0).margin(0.016));
  }
}

TEST_CASE("The trace by differences has the certificate's largest values") {
  for (const Method method : {Method::kThesis, Method::kConstant, Method::kDefault}) {
    const PlanResult r = plan_fig_4_2(method);
    REQUIRE(r.trace.size() == r.trajectory.samples());
    double acceleration = 0, jerk = 0;
    for (const TraceSample& t : r.trace) {
      acceleration = std::max(acceleration, t.total[1]);
      jerk = std::max(jerk, t.total[2]);
    }
    CHECK(acceleration / 500 == Approx(ratio(r, "total acceleration")).epsilon(1e-6));
    CHECK(jerk / 4000 <= ratio(r, "total jerk") * (1 + 1e-6));
    CHECK(jerk / 4000 > 0.7 * ratio(r, "total jerk"));
    CHECK(r.trace.back().s_mm == Approx(thesis::kFig42Length).margin(6));
  }
}

TEST_CASE("The deviation of samples is the largest distance from the path, by brute force") {
  RandomStream random(81, Purpose::kTest);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<Point2> path{{0, 0}}, samples;
    for (int i = 0; i < 30; ++i)
      path.push_back({path.back().x_mm + random.uniform(0.2, 4), path.back().y_mm + random.uniform(-1, 1)});
    for (std::size_t i = 0; i + 1 < path.size(); ++i)
      for (const double f : {0.0, 0.5})
        samples.push_back({path[i].x_mm + f * (path[i + 1].x_mm - path[i].x_mm) + random.uniform(-0.1, 0.1),
                           path[i].y_mm + f * (path[i + 1].y_mm - path[i].y_mm) + random.uniform(-0.1, 0.1)});
    double worst = 0;
    for (const Point2& p : samples) {
      double nearest = 1e300;
      for (std::size_t i = 0; i + 1 < path.size(); ++i)
        for (double f = 0; f <= 1.0001; f += 0.002)
          nearest =
              std::min(nearest, std::hypot(path[i].x_mm + f * (path[i + 1].x_mm - path[i].x_mm) - p.x_mm,
                                           path[i].y_mm + f * (path[i + 1].y_mm - path[i].y_mm) - p.y_mm));
      worst = std::max(worst, nearest);
    }
    REQUIRE(deviation(samples, path) == Approx(worst).margin(2e-4));
  }
}

TEST_CASE("A trajectory of more samples than memory holds is refused before it is made") {
  const auto arm = make_scara(cobra600());
  const std::vector<Point2> line{{300, 0}, {320, 0}};
  for (const Method method :
       {Method::kCertified, Method::kOptimal, Method::kThesis, Method::kConstant, Method::kDefault}) {
    INFO(name(method));
    PlanOptions options;
    options.method = method;
    PathInput in{.points = line};
    in.speed_limit.path_mm_s = 1e-9;
    const PlanResult slow = plan(in, *arm, cobra600_limits(), options);
    REQUIRE(slow.fault);
    CHECK(slow.fault->reason == Reason::kTooLong);
    options.tick_s = 1e-12;
    const PlanResult fine = plan({.points = line}, *arm, cobra600_limits(), options);
    REQUIRE(fine.fault);
    CHECK(fine.fault->reason == Reason::kTooLong);

    options.tick_s = 0.016;
    options.trace_step_s = 1e-12;
    const PlanResult traced = plan({.points = line}, *arm, cobra600_limits(), options);
    if (method == Method::kCertified || method == Method::kOptimal) {  // the others are traced at the tick
      REQUIRE(traced.fault);
      CHECK(traced.fault->reason == Reason::kTooLong);
    }
  }
}

TEST_CASE(
    "A stop that is asked for is a rest of the motion at that point, with every method that stops at "
    "corners") {
  const auto arm = make_scara(cobra600());
  std::vector<Point2> arc;
  for (int i = 0; i <= 150; ++i)
    arc.push_back({380.0 + 40.0 * std::cos(0.01 * i), 40.0 * std::sin(0.01 * i)});
  arc.push_back({arc.back().x_mm - 20.0, arc.back().y_mm - 5.0});  // and a corner of some 76 degrees
  arc.insert(arc.begin() + 20, arc[20]);                           // a point twice
  for (const Method method : {Method::kCertified, Method::kOptimal, Method::kThesis, Method::kConstant}) {
    INFO(name(method));
    PlanOptions options;
    options.method = method;
    PathInput in{.points = arc};
    const PlanResult plain = plan(in, *arm, cobra600_limits(), options);
    in.stops = {0, 21, 100, arc.size() - 1};  // the ends are rests in any case
    const PlanResult asked = plan(in, *arm, cobra600_limits(), options);
    REQUIRE(plain.ok());
    REQUIRE(asked.ok());
    CHECK(asked.stops == plain.stops + 2);
    REQUIRE(asked.stop_samples.size() == asked.stops);
    CHECK(asked.trajectory.certificate.duration_s > plain.trajectory.certificate.duration_s);
    for (const std::size_t k : {0, 1}) {
      const Point2 at = asked.tool[asked.stop_samples[k]], wanted = arc[k == 0 ? 21 : 100];
      CHECK(std::hypot(at.x_mm - wanted.x_mm, at.y_mm - wanted.y_mm) <
            0.2);  // within half a tick of the rest
    }
    if (method != Method::kCertified) continue;
    options.tolerance_mm = 0.5;  // corners may be rolled, the stops not
    const PlanResult rolled = plan(in, *arm, cobra600_limits(), options);
    REQUIRE(rolled.ok());
    CHECK(rolled.stops >= 2);
    in.stops = {3, 3};
    CHECK(plan(in, *arm, cobra600_limits(), options).fault->reason == Reason::kOption);
    in.stops = {arc.size()};
    CHECK(plan(in, *arm, cobra600_limits(), options).fault->reason == Reason::kOption);
  }
}

TEST_CASE("Every method answers bad input with a named reason and never throws") {
  const auto arm = make_scara(cobra600());
  const std::vector<Point2> hole{{300, 0}, {NAN, 0}}, one{{300, 0}}, far{{300, 0}, {700, 0}},
      line{{300, 0}, {320, 0}};
  for (const Method method :
       {Method::kCertified, Method::kOptimal, Method::kThesis, Method::kConstant, Method::kDefault}) {
    PlanOptions options;
    options.method = method;
    const auto reason = [&](const std::vector<Point2>& points, const MotionLimits& limits) {
      const PlanResult r = plan({.points = points}, *arm, limits, options);
      REQUIRE(r.fault);
      CHECK(r.trajectory.positions.empty());
      return r.fault->reason;
    };
    CHECK(reason(hole, cobra600_limits()) == Reason::kNotFinite);
    CHECK(reason(one, cobra600_limits()) == Reason::kTooFewPoints);
    CHECK(reason({}, cobra600_limits()) == Reason::kTooFewPoints);
    CHECK(reason(far, cobra600_limits()) == Reason::kReachFar);
    MotionLimits limits = cobra600_limits();
    limits.position.acceleration = 0;
    CHECK(reason(line, limits) == Reason::kLimitNotPositive);
    options.tick_s = -1;
    CHECK(reason(line, cobra600_limits()) == Reason::kOption);
  }
}
