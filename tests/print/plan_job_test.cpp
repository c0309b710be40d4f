#include "print/prepare/plan_job.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "core/deposition/delivery.h"
#include "core/grid/random.h"
#include "files/json.h"
#include "files/path/path_file.h"
#include "print/prepare/motion_program.h"
#include "print/prepare/plan_outputs.h"
#include "report/paths/plan_plot.h"

using namespace firn;
using Catch::Contains;

namespace {

const Machine kCobra;

InputPath some_path(std::int64_t number, RandomStream& random) {
  InputPath p;
  p.number = number;
  p.place = "job:" + std::to_string(number);
  Point2 at{random.uniform(0, 20), random.uniform(0, 20)};
  for (std::uint32_t n = 2 + random.below(60); n > 0; --n) {
    p.path.points.push_back(at);
    at.x_mm += random.uniform(-0.5, 1.0);
    at.y_mm += random.uniform(-0.5, 1.0);
  }
  return p;
}

std::vector<PlannedItem> planned(const std::vector<InputPath>& paths, int threads,
                                 const PlanJobOptions& how = {}) {
  PlanJobOptions options = how;
  options.threads = threads;
  options.origin = {380.0, -20.0};
  std::vector<PlannedItem> items;
  PlanJob job(kCobra, options, [&](PlannedItem&& item) { items.push_back(std::move(item)); });
  for (InputPath p : paths) job.add(std::move(p));
  job.finish();
  return items;
}

}  // namespace

TEST_CASE("Results come in the order of the paths, with the same bytes for any number of threads") {
  RandomStream random(86, Purpose::kTest);
  std::vector<InputPath> paths;
  for (std::int64_t n = 1; n <= 60; ++n) paths.push_back(some_path(n, random));
  paths[17].path.points = {{0, 0}, {900, 0}};  // out of reach
  const auto one = planned(paths, 1), three = planned(paths, 3);
  REQUIRE(one.size() == paths.size());
  REQUIRE(three.size() == paths.size());
  for (std::size_t n = 0; n < paths.size(); ++n) {
    CHECK(one[n].input.number == std::int64_t(n) + 1);
    CHECK(one[n].encoded == three[n].encoded);
    CHECK(one[n].result.ok() == (n != 17));
    CHECK(one[n].encoded.empty() == (n == 17));
  }
  CHECK_THAT(motion::describe(*one[17].result.fault), Contains("reach"));
}

TEST_CASE(
    "A tool that the machine lacks is refused with the nearest known one, and what the sink throws comes "
    "out") {
  RandomStream random(87, Purpose::kTest);
  PlanJob job(kCobra, {}, [](PlannedItem&&) { throw std::runtime_error("disk full"); });
  InputPath bad = some_path(1, random);
  bad.tool = "watre";
  CHECK_THROWS_WITH(job.add(std::move(bad)), Contains("job:1") && Contains("nearest known one is water"));
  job.add(some_path(1, random));
  CHECK_THROWS_WITH(job.finish(), Contains("disk full"));
}

TEST_CASE(
    "The CSV has a line per tick that reads back to the same numbers, and speeds from it are those of the "
    "path") {
  InputPath line;
  line.number = 1;
  line.path.points = {{0, 0}, {50, 0}, {100, 0}};
  PlanJobOptions how;
  how.keep_tool = true;
  const auto items = planned({line}, 1, how);
  REQUIRE(items[0].result.ok());
  CHECK(csv_header({"rad", "rad", "mm", "rad"}) == "t_s,x_mm,y_mm,joint_1_rad,joint_2_rad\n");
  std::istringstream lines(csv_lines(items[0]));
  std::string text;
  std::size_t n = 0;
  const Trajectory& t = items[0].result.trajectory;
  for (; std::getline(lines, text); ++n) {
    std::array<double, 5> v{};
    REQUIRE(std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf", &v[0], &v[1], &v[2], &v[3], &v[4]) == 5);
    CHECK(v[0] == Approx(double(n) * t.tick_s));
    CHECK(v[1] == items[0].result.tool[n].x_mm);
    CHECK(v[3] == t.positions[n * std::size_t(t.axes)]);
  }
  CHECK(n == t.samples());
  const std::vector<double> c = deposition::speeds_at_ticks(items[0].result.tool, t.tick_s);
  double length = 0.0;
  for (std::size_t k = 1; k < c.size(); ++k) length += 0.5 * t.tick_s * (c[k - 1] + c[k]);
  CHECK(length == Approx(100.0).margin(0.2));
}

TEST_CASE(
    "A G-code program takes the plan's time and passes the plan's points, read back by another reader") {
  InputPath bent;
  bent.number = 1;
  bent.path.points = {{0, 0}, {30, 0}, {30, 20}};
  bent.path.z_mm = 0.5;
  PlanJobOptions how;
  how.keep_tool = true;
  const auto items = planned({bent}, 1, how);
  REQUIRE(items[0].result.ok());
  const std::string program = gcode_head("arm (left)", "certified") + gcode_lines(items[0]) + gcode_tail();
  std::istringstream lines(program);
  std::string line;
  double at_x = 0.0, at_y = 0.0, time_s = 0.0;
  std::size_t n = 0;
  const std::vector<Point2>& tool = items[0].result.tool;
  while (std::getline(lines, line)) {
    double x = 0.0, y = 0.0, f = 0.0, p = 0.0;
    if (std::sscanf(line.c_str(), "G1 X%lf Y%lf F%lf", &x, &y, &f) == 3) {
      time_s += 60.0 * std::hypot(x - at_x, y - at_y) / f;
      ++n;
      at_x = x;
      at_y = y;
    } else if (std::sscanf(line.c_str(), "G4 P%lf", &p) == 1) {
      time_s += p;
      ++n;
    } else if (std::sscanf(line.c_str(), "G0 X%lf Y%lf", &at_x, &at_y) != 2) {
      continue;
    }
    REQUIRE(n < tool.size());
    CHECK(std::hypot(at_x - tool[n].x_mm, at_y - tool[n].y_mm) < 1e-6);
  }
  CHECK(n + 1 == tool.size());
  CHECK(time_s == Approx(items[0].result.trajectory.certificate.duration_s).epsilon(1e-7));
  std::istringstream again(program);
  std::vector<InputPath> read;
  read_paths_gcode(again, "p.nc", double(program.size()),
                   [&](InputPath&& q) { read.push_back(std::move(q)); });
  REQUIRE(read.size() == 1);
  CHECK(read[0].path.z_mm == 0.5);
  CHECK(distance(read[0].path.points.back(), {30, 20}) < 1e-6);
}

TEST_CASE("A path whose points are held says how far they are from its curve, others do not") {
  InputPath bent;
  bent.path.points = {{0, 0}, {10, 0}, {20, 0.5}, {30, 0.5}};
  PlanJobOptions how;
  CHECK(item_json(planned({bent}, 1, how)[0]).find("held_mm") == std::string::npos);
  how.plan.point_rule = motion::PointRule::kHeld;
  const auto items = planned({bent}, 1, how);
  const auto json = nlohmann::json::parse(item_json(items[0]));
  CHECK(json.at("points_off_mm") == items[0].result.points_off_mm);
  CHECK(json.at("points_off_mm") <= json.at("held_mm"));
}

TEST_CASE("Programs of motion controllers hold no number with an exponent, however short or long the tick") {
  for (const double tick_s : {1e-5, 0.016, 0.9, 10.0}) {
    PlannedItem item;
    item.result.tool = {{0, 0}, {1e-6, 0}, {1e-6, 0}, {5e4, 0}};
    item.result.trajectory.tick_s = tick_s;
    item.result.trajectory.axes = 1;
    for (const Point2& p : item.result.tool) item.result.trajectory.positions.push_back(p.x_mm);
    item.result.axis_rates.assign(4, 1e-7);
    const std::string program = gcode_lines(item), pvt = pvt_lines(item, {"X"});
    INFO(program << pvt);
    CHECK(program.find('e') == std::string::npos);
    CHECK(pvt.find("e-") == std::string::npos);
    CHECK(pvt.find("e+") == std::string::npos);
    double f = 0.0;
    REQUIRE(std::sscanf(program.c_str() + program.find('F'), "F%lf", &f) == 1);
    CHECK(f == Approx(6e-5 / tick_s).epsilon(1e-8));
  }
}

TEST_CASE("PVT lines are the emitted positions, their velocities and the time since the first") {
  InputPath bent;
  bent.number = 4;
  bent.path.points = {{0, 0}, {30, 0}, {30, 20}};
  PlanJobOptions how;
  how.plan.axis_rates = true;
  const auto items = planned({bent}, 1, how);
  REQUIRE(items[0].result.ok());
  const Trajectory& t = items[0].result.trajectory;
  std::istringstream lines(pvt_lines(items[0], {"X", "Y", "Z", "U"}));
  std::string line;
  std::size_t n = 0;
  REQUIRE(std::getline(lines, line));
  CHECK(line == "' path 4");
  REQUIRE(std::getline(lines, line));
  CHECK(line.starts_with("LINEAR X"));
  REQUIRE(std::getline(lines, line));
  CHECK(line == "WAIT MOVEDONE X Y Z U");
  REQUIRE(std::getline(lines, line));
  CHECK(line == "PVT INIT TIME ABS");
  while (std::getline(lines, line)) {
    ++n;
    double x = 0, vx = 0, y = 0, vy = 0, z = 0, vz = 0, u = 0, vu = 0, s = 0;
    REQUIRE(std::sscanf(line.c_str(), "PVT X%lf,%lf Y%lf,%lf Z%lf,%lf U%lf,%lf TIME %lf", &x, &vx, &y, &vy,
                        &z, &vz, &u, &vu, &s) == 9);
    CHECK(s == Approx(double(n) * t.tick_s));
    CHECK(x == Approx(t.positions[4 * n]).margin(1e-9));
    CHECK(vy == Approx(items[0].result.axis_rates[4 * n + 1]).margin(1e-9));
    if (n + 1 < t.samples())
      CHECK(vx == Approx((t.positions[4 * n + 4] - t.positions[4 * n - 4]) / (2.0 * t.tick_s)).margin(2e-3));
  }
  CHECK(n + 1 == t.samples());
}

TEST_CASE("Nominal pulses of a planned path count its volume, and too much flow is refused with the path") {
  InputPath line;
  line.number = 1;
  line.place = "job:2";
  line.path.points = {{0, 0}, {100, 0}};
  line.path.width_mm = 1.5;
  line.path.layer_height_mm = 0.25;
  PlanJobOptions how;
  how.keep_tool = true;
  const auto items = planned({line}, 1, how);
  REQUIRE(items[0].result.ok());
  const deposition::PulsePlan plan = nominal_pulses(items[0].input, items[0].result, kCobra.valve);
  REQUIRE(plan.trains.size() == 1);
  CHECK(double(plan.trains[0].ticks.size()) == Approx(150.0).margin(1.0));  // 4 Hz/(mm^3/s) x 37.5 mm^3
  CHECK(plan.min_drops_per_mm == Approx(1.5));
  line.path.layer_height_mm = 2.0;
  how.pulses = true;
  CHECK_THAT(planned({line}, 1, how)[0].problem, Contains("job:2") && Contains("above the valve's"));
}

TEST_CASE("A path longer than the controller's list is cut at its corners, without a rest more") {
  InputPath turns;
  turns.number = 1;
  turns.place = "job:3";
  turns.path.width_mm = 3.0;
  turns.path.layer_height_mm = 0.25;
  turns.speed_limit.path_mm_s = 1.0;
  for (int n = 0; n < 14; ++n)
    turns.path.points.push_back({n % 4 == 1 || n % 4 == 2 ? 30.0 : 0.0, 2.0 * (n / 2)});
  PlanJobOptions how;
  how.keep_tool = how.pulses = true;
  const auto items = planned({turns}, 1, how);
  REQUIRE(items[0].result.ok());
  CHECK(items[0].result.trajectory.certificate.duration_s > 200.0);
  const std::vector<double> speed = deposition::speeds_at_ticks(items[0].result.tool, 0.016);
  REQUIRE(items[0].result.stop_samples.size() == 12);
  for (std::size_t n : items[0].result.stop_samples) CHECK(speed[n] < 0.8 * speed[n + 8]);
  CHECK(items[0].pulse_plan.trains.size() == 2);
  CHECK(items[0].added_stops.empty());
}

TEST_CASE(
    "A path that never stops is given rests where its pulses need another list, at the slowest corner near") {
  const auto arc = [](double radius, double angle, double from) {
    std::vector<Point2> points;
    const int n = int(radius * angle / 0.4);
    for (int i = 0; i <= n; ++i)
      points.push_back({radius * std::cos(from + angle * i / n), radius * std::sin(from + angle * i / n)});
    return points;
  };
  InputPath straight, round, bent, dense;
  straight.path.points = {{-75, 0}, {75, 0}};  // 300 s at 0.5 mm/s: no point inside to stop at
  straight.speed_limit.path_mm_s = 0.5;
  round.path.points = arc(30.0, 6.0, 0.0);  // 300 s and no corner
  round.speed_limit.path_mm_s = 0.6;
  bent = straight;  // a corner of 20 degrees, which needs no stop, and one of 8
  bent.path.points = {{-75, 0}, {-24, 0}, {5, 14}, {75, 43}};
  dense.path.points = arc(40.0, 150.0, 0.0);  // 6 m: in time, but 18,000 drops
  std::vector<InputPath> paths{straight, round, bent, dense};
  for (std::size_t n = 0; n < paths.size(); ++n) {
    paths[n].number = std::int64_t(n) + 1;
    paths[n].place = "job:" + std::to_string(n);
    paths[n].path.width_mm = 3.0;
    paths[n].path.layer_height_mm = 0.25;
  }
  PlanJobOptions how;
  how.keep_tool = how.pulses = true;
  const auto items = planned(paths, 2, how);
  for (std::size_t n = 0; n < items.size(); ++n) {
    INFO("path " << n << ": " << items[n].problem);
    const motion::PlanResult& r = items[n].result;
    REQUIRE(r.ok());
    REQUIRE(items[n].problem.empty());
    const deposition::ValveLimits limits = valve_limits(kCobra.valve);
    const deposition::ValveSetting setting = valve_setting(kCobra.valve);
    const auto& trains = items[n].pulse_plan.trains;
    CHECK(trains.size() == (n < 3 ? 3u : 2u));
    CHECK(items[n].added_stops.size() == trains.size() - 1);
    CHECK(r.stops == items[n].added_stops.size());
    const deposition::FlowDemand demand = nominal_demand(items[n].input.path, r);
    for (const auto& train : trains) {
      CHECK(double(train.last_instant - train.first_instant) * demand.step_s <= limits.max_duration_s);
      CHECK(train.ticks.size() <= std::size_t(limits.max_entries));
      CHECK((train.first_instant == 0 ||
             demand.speed_mm_s[train.first_instant] < 0.6 * demand.speed_mm_s[train.first_instant + 8]));
    }
    // no volume is lost between the lists, and the half drop stays the bound
    const auto drops = deposition::drops_of(items[n].pulse_plan, demand, setting.curve, limits.tick_s);
    const auto error = deposition::count_delivery(
        demand, drops, deposition::granted_by(demand, setting.curve, limits.tick_s), 0.0);
    CHECK(error.worst_excess_mm3 <= 1e-9);
    const Path& path = items[n].input.path;
    CHECK(error.wanted_mm3 ==
          Approx(items[n].length_mm * path.width_mm * path.layer_height_mm).epsilon(1e-3));
    CHECK(std::abs(error.delivered_mm3 - error.wanted_mm3) <= 0.5 / 4.0 + 1e-9);
    for (const LimitRatio& limit : r.trajectory.certificate.limits) CHECK(limit.ratio <= 1.001);
    CHECK_THAT(item_json(items[n]),
               Contains("\"pulse_lists\":" + std::to_string(trains.size())) && Contains("\"along_mm\":"));
  }
  CHECK(items[0].input.path.points.size() == 4);
  CHECK_FALSE(items[0].added_stops[0].corner);
  CHECK(items[0].added_stops[0].along_mm == Approx(50.0).margin(1.0));
  CHECK(items[1].input.path.points.size() == round.path.points.size());
  CHECK(items[2].added_stops[0].corner);
  CHECK(items[2].added_stops[0].at == Point2{-24, 0});
  how.plan.method = motion::Method::kThesis;
  CHECK(planned({paths[1]}, 1, how)[0].problem == "");
  how.plan.method = motion::Method::kDefault;  // which stops nowhere
  CHECK_THAT(planned({paths[0]}, 1, how)[0].problem,
             Contains("job:0") && Contains("131.07") && Contains("stop before"));
}

TEST_CASE(
    "A path with a yaw per point is planned with its orientation limits, also where a rest adds a point") {
  Machine machine;
  machine.orientation.rate = 0.5;
  InputPath line;
  line.number = 1;
  line.place = "job:1";
  line.path.points = {{-50, 0}, {50, 0}};
  line.yaw_point_rad = {0.0, 2.0};  // 229 s at half a degree per second
  line.path.width_mm = 3.0;
  line.path.layer_height_mm = 0.25;
  PlanJobOptions how;
  how.keep_tool = how.pulses = true;
  how.origin = {380.0, -20.0};
  std::vector<PlannedItem> items;
  PlanJob job(machine, how, [&](PlannedItem&& item) { items.push_back(std::move(item)); });
  job.add(std::move(line));
  job.finish();
  REQUIRE(items[0].problem.empty());
  REQUIRE(items[0].result.ok());
  CHECK(items[0].pulse_plan.trains.size() == 2);
  CHECK(items[0].input.yaw_point_rad.size() == 3);
  CHECK(items[0].result.yaw_rad.back() == Approx(2.0));
  const Certificate& c = items[0].result.trajectory.certificate;
  CHECK(c.duration_s == Approx(2.0 / (0.5 * 3.141592653589793 / 180.0)).epsilon(0.01));
  const auto rate = std::find_if(c.limits.begin(), c.limits.end(),
                                 [](const LimitRatio& l) { return l.limit == "orientation rate"; });
  REQUIRE(rate != c.limits.end());
  CHECK(rate->ratio == Approx(1.0).margin(0.002));
}

TEST_CASE("The plot is one SVG with a chart per quantity, whatever the trace holds") {
  report::PlanPlot plot;
  plot.title = "a < b";
  plot.limits = motion_limits(kCobra);
  plot.joint_names = {"J1", "J2"};
  plot.joint_units = {"rad", "rad"};
  for (int n = 0; n < 5000; ++n) {
    motion::TraceSample t;
    t.t_s = 0.001 * n;
    t.at = {std::cos(t.t_s), std::sin(t.t_s)};
    t.total = {50.0, n % 7 == 0 ? std::nan("") : 100.0, 1e4};
    plot.trace.push_back(t);
  }
  const std::string svg = report::plan_picture(plot);
  CHECK(svg.find("a &lt; b") != std::string::npos);
  CHECK(svg.find("nan") == std::string::npos);
  std::size_t opened = 0, closed = 0;
  for (std::size_t at = svg.find("<svg"); at != svg.npos; at = svg.find("<svg", at + 1)) ++opened;
  for (std::size_t at = svg.find("</svg>"); at != svg.npos; at = svg.find("</svg>", at + 1)) ++closed;
  CHECK(opened == closed);
  CHECK(opened == 1 + 11 + 11 + 9);  // whole, eleven places, eleven pictures, nine clipped plots
  CHECK(svg.size() < 600000);
}
