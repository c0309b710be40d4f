#include "core/planning/path_planning.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "config/ice_lab.h"
#include "core/deposition/delivery.h"
#include "core/motion/kinematics/jets.h"
#include "tests/support/ice_print.h"

namespace firn::planning {
namespace {

PlanningSetup setup(control::SurfaceVersion version) {
  Experiment e = test::ice_experiment();
  e.control.surface.version = version;
  PlanningSetup s = planning_setup(e, test::cobra());
  for (ValveSetup& v : s.valves) v.latency_s = 0.0;
  return s;
}

PathTask circle(double radius_mm, double width_mm = 1.5) {
  PathTask t;
  t.layer = 1;
  t.closed = true;
  t.width_mm = width_mm;
  t.layer_height_mm = 0.24;
  t.z_mm = 3.24;
  t.tool = "water";
  for (int n = 0; n < 60; ++n)
    t.points.push_back(
        {radius_mm * std::cos(n * 6.283185307179586 / 60), radius_mm * std::sin(n * 6.283185307179586 / 60)});
  return t;
}

PathTask line() {
  PathTask t = circle(1.0);
  t.closed = false;
  t.points = {{-38.0, 5.0}, {38.0, -5.0}};
  return t;
}

HeightMap surface(double (*u)(double, double)) {
  HeightMap a({81, 81, 1.0, 1.0, -40.0, -40.0});
  for (int j = 0; j < 81; ++j)
    for (int i = 0; i < 81; ++i) a.at(i, j) = u(a.spec.x_mm(i), a.spec.y_mm(j));
  return a;
}

/// Where the tool of the arm is at a sample, in the part's frame.
motion::TaskVector tool_at(const PlanningSetup& s, const motion::Arm& arm, const motion::Tool& tool,
                           const Trajectory& t, std::size_t sample) {
  motion::JointVector q{};
  for (int a = 0; a < t.axes; ++a)
    q[std::size_t(a)] = t.positions[sample * std::size_t(t.axes) + std::size_t(a)];
  const motion::TaskVector flange = arm.forward(q);
  const double c = std::cos(flange[3]), n = std::sin(flange[3]);
  return {flange[0] + c * tool.x_mm - n * tool.y_mm - s.origin.x_mm,
          flange[1] + n * tool.x_mm + c * tool.y_mm - s.origin.y_mm, flange[2] + tool.z_mm - s.origin_z_mm,
          flange[3]};
}

}  // namespace

TEST_CASE(
    "(5.7)-(5.9): in the speed version the arm follows c_nom / (1 + u), never faster, at constant frequency "
    "where it does") {
  const PlanningSetup s = setup(control::SurfaceVersion::kPathSpeed);
  TaskPlanner planner(s);
  const HeightMap action = surface([](double x, double) { return 0.2 * std::sin(0.1 * x); });
  const PlannedTask p = planner.plan(line(), &action);
  REQUIRE(p.problem.empty());
  const double tick = p.trajectory.tick_s;
  const std::vector<double> c = deposition::speeds_at_ticks(p.tool, tick);
  double away = 0.0;
  for (std::size_t n = 20; n + 20 < c.size(); ++n) {
    const double wanted = control::speed_for(25.0, deposition::action_at(action, p.tool[n]));
    CHECK(c[n] <= wanted * 1.02);  // the speed limit holds at points 2 mm apart
    away = std::max(away, 1.0 - c[n] / wanted);
  }
  CHECK(away < 0.1);
  REQUIRE(p.lists.size() == 1);
  const double hz = 4.0 * 25.0 * 1.5 * 0.24;  // (5.14): c_ff c w dh_d
  const std::vector<std::int32_t>& ticks = p.lists[0].ticks;
  double length = 0.0, wanted = 0.0;
  for (std::size_t n = 1; n < ticks.size(); ++n) {
    const double gap_s = 0.002 * (ticks[n] - ticks[n - 1]);
    if (n > 8 && n + 8 < ticks.size()) CHECK(gap_s == Approx(1.0 / hz).margin(0.0025));
    CHECK(gap_s >= 1.0 / hz - 0.0025);  // slower only where the arm cannot reach its speed
  }
  for (std::size_t n = 1; n < p.tool.size(); ++n) {
    const double step = std::hypot(p.tool[n].x_mm - p.tool[n - 1].x_mm, p.tool[n].y_mm - p.tool[n - 1].y_mm);
    length += step;
    wanted += (1.0 + deposition::action_at(action, p.tool[n])) * 1.5 * 0.24 * step;
  }
  CHECK(p.volume_mm3 == Approx(wanted).epsilon(2e-3));
  CHECK(length == Approx(p.length_mm).epsilon(1e-6));
  for (const LimitRatio& r : p.trajectory.certificate.limits) CHECK(r.ratio <= 1.0 + 1e-9);
}

TEST_CASE(
    "(6.2)-(6.6): in the frequency version every stretch of path gets (1 + u) w dh per length, at any "
    "speed") {
  const PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  TaskPlanner planner(s);
  const HeightMap action =
      surface([](double x, double y) { return 0.3 * std::sin(0.1 * x) + 0.1 * std::cos(0.07 * y); });
  const PlannedTask plain = planner.plan(circle(30.0), nullptr), p = planner.plan(circle(30.0), &action);
  REQUIRE(p.problem.empty());
  CHECK(plain.trajectory.positions == p.trajectory.positions);
  CHECK(planner.motions_planned() == 1);
  // wanted volume up to each pulse against drops of 0.25 mm^3 so far
  double wanted = 0.0;
  std::size_t next = 0, drops = 0;
  const std::vector<std::int32_t>& ticks = p.lists[0].ticks;
  for (std::size_t n = 0; n + 1 < p.tool.size(); ++n) {
    const double u =
        0.5 * (deposition::action_at(action, p.tool[n]) + deposition::action_at(action, p.tool[n + 1]));
    const double step = std::hypot(p.tool[n + 1].x_mm - p.tool[n].x_mm, p.tool[n + 1].y_mm - p.tool[n].y_mm);
    wanted += (1.0 + u) * 1.5 * 0.24 * step;
    for (; next < ticks.size() && 0.002 * ticks[next] <= p.trajectory.tick_s * double(n + 1); ++next) ++drops;
    CHECK(std::abs(wanted - 0.25 * double(drops)) < 0.25 * 0.5 + 0.1);
  }
  CHECK(drops == ticks.size());
  CHECK(p.volume_mm3 == Approx(wanted).epsilon(1e-3));
}

TEST_CASE("Nozzles and laser stand where their paths are, each with its own offset and height") {
  const PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  TaskPlanner planner(s);
  const auto arm = s.arm.kinematics;
  const slice::PrintPaths paths = test::ice_print();
  const slice::LayerPaths& layer = *slice::find_layer(paths, 5);
  int seen = 0;
  for (const bool measurement : {false, true})
    for (const PathTask& t : tasks_of(paths, layer, measurement, s)) {
      const PlannedTask p = planner.plan(t, nullptr);
      REQUIRE(p.problem.empty());
      const motion::Tool tool = measurement ? s.laser : s.arm.tools[t.material == 0 ? 1 : 2];
      for (std::size_t n = 0; n < p.tool.size(); n += 10) {
        const motion::TaskVector at = tool_at(s, *arm, tool, p.trajectory, n);
        CHECK(at[0] == Approx(p.tool[n].x_mm).margin(1e-6));
        CHECK(at[1] == Approx(p.tool[n].y_mm).margin(1e-6));
        CHECK(at[2] == Approx(measurement ? 1.2 : 1.2 + s.nozzle_gap_mm));
      }
      CHECK(p.lists.empty() == measurement);
      ++seen;
    }
  CHECK(seen > 12);
}

TEST_CASE(
    "Samples of a smooth curve are followed faster within the tolerance than through them, in every limit") {
  PathTask rose = circle(20.0);
  rose.kind = PathKind::kMeasurement;
  rose.tool = "laser";
  rose.points.clear();
  for (int n = 0; n < 400; ++n) {
    constexpr double kTurn = 6.283185307179586;
    const double a = kTurn * n / 400.0, r = 20.0 + 4.0 * std::cos(5.0 * a);
    rose.points.push_back({std::round(1e3 * r * std::cos(a)) / 1e3, std::round(1e3 * r * std::sin(a)) / 1e3});
  }
  PlanningSetup s = setup(control::SurfaceVersion::kPathSpeed);
  const PlannedTask fitted = TaskPlanner(s).plan(rose, nullptr);
  s.tolerance_mm = 0.0;
  const PlannedTask through = TaskPlanner(s).plan(rose, nullptr);
  REQUIRE(through.problem.empty());
  REQUIRE(fitted.problem.empty());
  CHECK(fitted.trajectory.certificate.duration_s < 0.99 * through.trajectory.certificate.duration_s);
  for (const LimitRatio& r : fitted.trajectory.certificate.limits) CHECK(r.ratio <= 1.0);
}

TEST_CASE("A path that is met again in another layer is not planned again, and only joint 3 differs") {
  const PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  TaskPlanner planner(s);
  PathTask t = circle(20.0);
  const PlannedTask low = planner.plan(t, nullptr);
  planner.next_batch();
  t.layer = 6;
  t.z_mm += 1.2;
  const PlannedTask high = planner.plan(t, nullptr);
  CHECK(planner.motions_planned() == 1);
  for (std::size_t k = 0; k < low.trajectory.positions.size(); ++k)
    CHECK(high.trajectory.positions[k] ==
          Approx(low.trajectory.positions[k] + (k % 4 == 2 ? 1.2 : 0.0)).margin(1e-12));
  planner.next_batch();
  planner.next_batch();
  planner.plan(t, nullptr);
  CHECK(planner.motions_planned() == 2);  // forgotten after a batch without it
}

TEST_CASE("Pulses come earlier by the valve's latency, in order and not before the signal") {
  PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  const std::vector<std::int32_t> late = TaskPlanner(s).plan(circle(20.0), nullptr).lists[0].ticks;
  s.valves[0].latency_s = 0.03;
  const std::vector<std::int32_t> early = TaskPlanner(s).plan(circle(20.0), nullptr).lists[0].ticks;
  REQUIRE(late.size() == early.size());
  for (std::size_t n = 0; n < late.size(); ++n) {
    CHECK(early[n] >= 0);
    if (n > 0) CHECK(early[n] > early[n - 1]);
    if (late[n] > 40) CHECK(early[n] == late[n] - 15);
  }
}

TEST_CASE(
    "A path with more pulses than a list holds is given rests and cut there, and no volume is lost between "
    "lists") {
  PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  const PlannedTask whole = TaskPlanner(s).plan(circle(35.0), nullptr);
  s.valve_limits.max_entries = 100;
  const PlannedTask cut = TaskPlanner(s).plan(circle(35.0), nullptr);
  REQUIRE(cut.problem.empty());
  CHECK(cut.lists.size() >= 4);
  CHECK(std::abs(double(cut.pulses() - whole.pulses())) <= 1.0);
  double volume = 0.0;
  for (std::size_t n = 0; n < cut.lists.size(); ++n) {
    CHECK(cut.lists[n].ticks.size() <= 100);
    volume += cut.lists[n].volume_mm3;
    const double sample = cut.lists[n].start_s / cut.trajectory.tick_s;
    CHECK(sample == Approx(std::round(sample)).margin(1e-9));
    if (n == 0) continue;
    const std::size_t at = std::size_t(std::llround(sample));  // the arm rests there
    CHECK(std::hypot(cut.tool[at + 1].x_mm - cut.tool[at].x_mm, cut.tool[at + 1].y_mm - cut.tool[at].y_mm) <
          0.02);
  }
  CHECK(volume == Approx(cut.volume_mm3));
  s.valve_limits.max_duration_s = 0.05;
  CHECK_FALSE(TaskPlanner(s).plan(circle(35.0), nullptr).problem.empty());
}

TEST_CASE("More flow than the valve gives is left out and told") {
  PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  s.speeds[0] = {125.0, 125.0, 50.0};
  const PlannedTask p =
      TaskPlanner(s).plan(circle(35.0, 8.0), nullptr);  // some 80 mm^3/s fit, twice as much does not
  CHECK(p.clipped_mm3 == 0.0);
  const HeightMap more = surface([](double, double) { return 1.0; });
  const PlannedTask q = TaskPlanner(s).plan(circle(35.0, 8.0), &more);
  CHECK(q.problem.empty());
  CHECK(q.clipped_mm3 > 0.0);
}

TEST_CASE(
    "A path out of the arm's reach is refused by name and place, and so is a tool that the machine has not") {
  const PlanningSetup s = setup(control::SurfaceVersion::kValveFrequency);
  TaskPlanner planner(s);
  PathTask far = circle(20.0);
  for (Point2& p : far.points) p.x_mm += 600.0;
  CHECK(planner.unreachable(circle(20.0)).empty());
  CHECK(planner.unreachable(far).find("reach") != std::string::npos);
  const PlannedTask p = planner.plan(far, nullptr);
  CHECK(p.problem.find("reach") != std::string::npos);
  CHECK(p.trajectory.positions.empty());
  PathTask high = circle(20.0);
  high.z_mm = 300.0;
  CHECK_FALSE(planner.unreachable(high).empty());
  PathTask unknown = circle(20.0);
  unknown.tool = "syrup";
  CHECK(planner.unreachable(unknown).find("syrup") != std::string::npos);
  CHECK(planner.plan(unknown, nullptr).problem.find("syrup") != std::string::npos);
}

TEST_CASE(
    "A long measurement path is divided into equal pieces that join, and lines without length are left out") {
  PlanningSetup s = setup(control::SurfaceVersion::kPathSpeed);
  s.speeds[0].measure_mm_s = 0.5;
  slice::PrintPaths paths = test::ice_print(5);
  slice::LayerPaths& layer = paths.layers.back();
  layer.lines.add(std::vector<geometry::Point>{{0, 0}, {100, 0}});
  layer.info.push_back({PathKind::kMeasurement, 0, false, 0});
  const std::vector<PathTask> tasks = tasks_of(paths, layer, true, s);
  const PathTask* before = nullptr;
  double length = 0.0;
  int joined = 0;
  for (const PathTask& t : tasks) {
    if (t.material != 0) continue;
    double mm = 0.0;
    for (std::size_t n = 1; n < t.points.size(); ++n)
      mm += std::hypot(t.points[n].x_mm - t.points[n - 1].x_mm, t.points[n].y_mm - t.points[n - 1].y_mm);
    if (t.closed)
      mm += std::hypot(t.points.front().x_mm - t.points.back().x_mm,
                       t.points.front().y_mm - t.points.back().y_mm);
    CHECK(mm <= 0.8 * s.valve_limits.max_duration_s);
    CHECK(mm > 0.01);
    length += mm;
    if (before && before->points.back() == t.points.front()) ++joined;
    before = &t;
  }
  double whole = 0.0;
  for (double r = 12.5 - 1.0; r > 0.0; r -= 2.0) whole += 8.0 * r;
  CHECK(length == Approx(whole).epsilon(1e-4));
  CHECK(joined >= 3);
}

TEST_CASE("What the planner cannot be made from is refused by name") {
  Machine stage = test::cobra();
  stage.kind = "stage";
  CHECK_THROWS_WITH(planning_setup(test::ice_experiment(), stage), Catch::Contains("scara"));
  PlanningSetup s = setup(control::SurfaceVersion::kPathSpeed);
  s.arm.kinematics = nullptr;
  CHECK_THROWS_WITH(TaskPlanner(s), Catch::Contains("there is none"));
  s = setup(control::SurfaceVersion::kPathSpeed);
  s.valves.pop_back();
  CHECK_THROWS_WITH(TaskPlanner(s), Catch::Contains("two valves"));
  s = setup(control::SurfaceVersion::kPathSpeed);
  s.valves[1].setting.pulse_s = 1e-5;
  CHECK_THROWS_WITH(TaskPlanner(s), Catch::Contains("pulse_s"));
}

}  // namespace firn::planning
