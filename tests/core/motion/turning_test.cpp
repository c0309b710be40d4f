// Paths along which the tool turns: a yaw per point.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/grid/random.h"
#include "core/motion/kinematics/tool.h"
#include "core/motion/planner.h"
#include "tests/core/motion/random_paths.h"

namespace firn::motion {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Method kEveryMethod[] = {Method::kCertified, Method::kOptimal, Method::kThesis, Method::kConstant,
                                   Method::kDefault};

double turning_ratio(const PlanResult& result) {
  double most = 0.0;
  for (const LimitRatio& limit : result.trajectory.certificate.limits) most = std::max(most, limit.ratio);
  return most;
}

/// Largest rate, acceleration and jerk of a series by differences, as an outsider forms them.
std::array<double, 3> differences(const std::vector<double>& q, double h) {
  std::array<double, 3> most{};
  for (std::size_t i = 0; i + 3 < q.size(); ++i) {
    const double d[3] = {(q[i + 1] - q[i]) / h, (q[i + 2] - 2 * q[i + 1] + q[i]) / (h * h),
                         (q[i + 3] - 3 * q[i + 2] + 3 * q[i + 1] - q[i]) / (h * h * h)};
    for (std::size_t k = 0; k < 3; ++k) most[k] = std::max(most[k], std::abs(d[k]));
  }
  return most;
}

std::vector<double> joint(const PlanResult& r, std::size_t j) {
  std::vector<double> q;
  for (std::size_t n = 0; n < r.trajectory.samples(); ++n) q.push_back(r.trajectory.positions[4 * n + j]);
  return q;
}

MotionLimits turning_limits() {
  MotionLimits limits = cobra600_limits();
  limits.orientation = {60 * kDegree, 300 * kDegree, 2400 * kDegree};
  limits.joint[3] = {70 * kDegree, 350 * kDegree, 2800 * kDegree};
  return limits;
}

/// An arc of 40 mm radius about (400, 0) whose tool points along it.
PathInput tangent_arc(std::vector<Point2>& points, double angle) {
  points.clear();
  PathInput in;
  for (int i = 0; 0.4 * i <= 40.0 * angle; ++i) {
    const double a = 0.01 * i;
    points.push_back({400.0 + 40.0 * std::cos(a), 40.0 * std::sin(a)});
    in.yaw_point_rad.push_back(a + 0.5 * std::numbers::pi);
  }
  in.points = points;
  return in;
}

}  // namespace

TEST_CASE(
    "A tool that turns with its path: J4 = phi - theta_1 - theta_2, and the arm's own kinematics give tool "
    "and yaw back") {
  const auto arm = make_scara(cobra600());
  std::vector<Point2> points;
  for (const Method method : {Method::kCertified, Method::kOptimal})
    for (const Tool& tool : cobra600_tools()) {
      PathInput in = tangent_arc(points, 3.0);
      in.tool = tool;
      PlanOptions options;
      options.method = method;
      const PlanResult r = plan(in, *arm, turning_limits(), options);
      INFO(name(method) << " " << tool.name << " " << (r.fault ? describe(*r.fault) : ""));
      REQUIRE(r.ok());
      REQUIRE(r.yaw_rad.size() == r.trajectory.samples());
      CHECK(r.yaw_rad.front() == Approx(in.yaw_point_rad.front()).margin(1e-12));
      CHECK(r.yaw_rad.back() == Approx(in.yaw_point_rad.back()).margin(1e-12));
      const std::size_t count = r.trajectory.samples();
      Jets joints(4, count), pose(kTaskAxes, count);
      for (int j = 0; j < 4; ++j)
        for (int order = 0; order < 4; ++order)
          for (std::size_t n = 0; n < count; ++n)
            joints.of(j, order)[n] = order == 0 ? r.trajectory.positions[4 * n + std::size_t(j)] : 0.0;
      arm->forward(joints, pose);
      flange_to_tool(tool, pose, pose);
      for (std::size_t n = 0; n < count; ++n) {
        CHECK(std::abs(pose.of(kX, 0)[n] - r.tool[n].x_mm) < 1e-9);
        CHECK(std::abs(pose.of(kY, 0)[n] - r.tool[n].y_mm) < 1e-9);
        CHECK(std::abs(std::remainder(pose.of(kYaw, 0)[n] - r.yaw_rad[n], 2 * std::numbers::pi)) < 1e-12);
        // on the arc the tool points along it
        const double a = std::atan2(r.tool[n].y_mm, r.tool[n].x_mm - 400.0);
        CHECK(std::abs(r.yaw_rad[n] - (a + 0.5 * std::numbers::pi)) < 2e-4);
        CHECK(std::abs(std::hypot(r.tool[n].x_mm - 400.0, r.tool[n].y_mm) - 40.0) < 1e-3);
      }
      CHECK(turning_ratio(r) <= 1.001);
    }
}

TEST_CASE("Limits of orientation and wrist bind, hold by differences, and the certificate names them") {
  const auto arm = make_scara(cobra600());
  const std::vector<Point2> line{{380, -40}, {380, 0}, {380, 40}};
  PathInput in{.points = line};
  const PlanResult plain = plan(in, *arm, turning_limits());
  in.yaw_point_rad = {0.0, 0.5, 3.0};  // 0.7 and 3.6 degrees per mm
  for (const Method method : {Method::kCertified, Method::kOptimal}) {
    PlanOptions options;
    options.method = method;
    const PlanResult r = plan(in, *arm, turning_limits(), options);
    REQUIRE(r.ok());
    CHECK(r.trajectory.certificate.duration_s > 1.5 * plain.trajectory.certificate.duration_s);
    CHECK(r.trajectory.certificate.lower_bound_s < r.continuous_s);
    CHECK(r.trajectory.certificate.lower_bound_s > plain.trajectory.certificate.lower_bound_s);
    CHECK(turning_ratio(r) <= 1.001);
    double orientation = 0.0, wrist = 0.0;
    for (const LimitRatio& l : r.trajectory.certificate.limits) {
      if (l.limit.starts_with("orientation")) orientation = std::max(orientation, l.ratio);
      if (l.limit.starts_with("J4")) wrist = std::max(wrist, l.ratio);
    }
    CHECK(std::max(orientation, wrist) > 0.98);
    const MotionLimits limits = turning_limits();
    for (const auto& [series, limit] :
         {std::pair{r.yaw_rad, limits.orientation}, {joint(r, 3), limits.joint[3]}}) {
      const auto most = differences(series, r.trajectory.tick_s);
      CHECK(most[0] <= 1.001 * limit.rate);
      CHECK(most[1] <= 1.001 * limit.acceleration);
      CHECK(most[2] <= 1.001 * limit.jerk);
    }
    // the kink is rounded by at most (jump of the slope) w / 6, the rest is followed
    for (std::size_t n = 0; n < r.tool.size(); ++n) {
      const double s = r.tool[n].y_mm + 40.0,
                   given = s < 40.0 ? 0.5 * s / 40.0 : 0.5 + 2.5 * (s - 40.0) / 40.0;
      CHECK(std::abs(r.yaw_rad[n] - given) <= 2.0 / 40.0 * 0.4 / 6.0 + 1e-4);
    }
  }
}

TEST_CASE("Equal yaws at all points are the constant yaw: the same bytes") {
  const auto arm = make_scara(cobra600());
  RandomPathMaker maker(5);
  for (int k = 0; k < 30; ++k) {
    const RandomPath path = maker.next();
    PathInput one{.points = path.points}, list = one;
    one.yaw_rad = 0.4;
    list.yaw_point_rad.assign(path.points.size(), 0.4);
    const PlanResult a = plan(one, *arm, turning_limits()), b = plan(list, *arm, turning_limits());
    REQUIRE(a.ok() == b.ok());
    CHECK(a.trajectory.positions == b.trajectory.positions);
    CHECK(b.yaw_rad.empty());
  }
}

TEST_CASE(
    "No limit is exceeded on random paths with random yaws, by differences of samples 16 times finer than "
    "the tick") {
  const auto arm = make_scara(cobra600());
  RandomPathMaker maker(20260);
  RandomStream draw(20261, Purpose::kTest);
  PlanWorkspace work;
  PlanOptions options;
  options.tick_s = 0.001;
  const MotionLimits limits = turning_limits();
  int planned = 0;
  for (int k = 0; k < 120; ++k) {
    const RandomPath path = maker.next();
    PathInput in{.points = path.points};
    double yaw = draw.uniform(-1.0, 1.0), slope = 0.0;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      if (i > 0)
        yaw += slope * std::hypot(path.points[i].x_mm - path.points[i - 1].x_mm,
                                  path.points[i].y_mm - path.points[i - 1].y_mm);
      if (draw.below(10) == 0) slope = std::abs(yaw) > 2.0 ? -0.02 * yaw : draw.uniform(-0.1, 0.1);
      in.yaw_point_rad.push_back(yaw);
    }
    in.tool = cobra600_tools()[draw.below(4)];
    const PlanResult r = plan(in, *arm, limits, options, work);
    INFO("path " << k << " (" << path.kind << ", " << path.points.size() << " points) "
                 << (r.fault ? describe(*r.fault) : ""));
    if (!r.ok()) {
      CHECK((r.fault->reason == Reason::kReachFar || r.fault->reason == Reason::kJointLow ||
             r.fault->reason == Reason::kJointHigh || r.fault->reason == Reason::kDespin));
      continue;
    }
    ++planned;
    CHECK(turning_ratio(r) <= 1.001);
    const auto wrist = differences(joint(r, 3), options.tick_s);
    CHECK(wrist[0] <= 1.001 * limits.joint[3].rate);
    CHECK(wrist[1] <= 1.001 * limits.joint[3].acceleration);
    CHECK(wrist[2] <= 1.001 * limits.joint[3].jerk);
  }
  CHECK(planned > 80);
}

TEST_CASE("Yaws that cannot be followed are refused by name") {
  const auto arm = make_scara(cobra600());
  std::vector<Point2> points;
  PathInput in = tangent_arc(points, 3.0);
  const auto reason = [&](const PathInput& input, const PlanOptions& options = {}) {
    const PlanResult r = plan(input, *arm, turning_limits(), options);
    return r.fault ? r.fault->reason : Reason::kNoSolution;
  };
  for (std::size_t i = 0; i < in.yaw_point_rad.size(); ++i) in.yaw_point_rad[i] = 0.05 * double(i);
  CHECK(reason(in) == Reason::kDespin);  // 860 degrees
  in.yaw_point_rad.pop_back();
  CHECK(reason(in) == Reason::kYawSize);
  in.yaw_point_rad.push_back(NAN);
  CHECK(reason(in) == Reason::kNotFinite);
  const std::vector<Point2> twice{{380, 0}, {400, 0}, {400, 0}, {420, 0}};
  PathInput spot{.points = twice};
  spot.yaw_point_rad = {0, 0.1, 0.2, 0.3};
  CHECK(reason(spot) == Reason::kYawJump);
  spot.yaw_point_rad = {0, 0.1, 0.1, 0.3};
  CHECK(plan(spot, *arm, turning_limits()).ok());
  const auto stage = make_stage({{{0.0, 500.0}, {-100.0, 100.0}}});
  for (const Method method : kEveryMethod) {
    PlanOptions options;
    options.method = method;
    CHECK(plan(spot, *arm, turning_limits(), options).ok());
    CHECK(plan(spot, *stage, cobra600_limits(), options).fault->reason == Reason::kOption);
    in.yaw_point_rad.back() = 0.05 * double(in.yaw_point_rad.size());
    CHECK(reason(in, options) == Reason::kDespin);
  }
}

TEST_CASE(
    "The methods of samples turn the tool with their points, by the arm's own kinematics, and their "
    "certificates say what it costs") {
  const auto arm = make_scara(cobra600());
  std::vector<Point2> points;
  for (const Method method : {Method::kThesis, Method::kConstant, Method::kDefault}) {
    PathInput in = tangent_arc(points, 3.0);
    in.tool = cobra600_tools()[1];
    PlanOptions options;
    options.method = method;
    const PlanResult r = plan(in, *arm, turning_limits(), options);
    INFO(name(method) << " " << (r.fault ? describe(*r.fault) : ""));
    REQUIRE(r.ok());
    REQUIRE(r.yaw_rad.size() == r.trajectory.samples());
    CHECK(r.yaw_rad.front() == Approx(in.yaw_point_rad.front()).margin(1e-6));
    CHECK(r.yaw_rad.back() == Approx(in.yaw_point_rad.back()).margin(1e-6));
    const double off = method == Method::kDefault ? 0.2 : 2e-3;  // points at 3.5 mm, rounded at 125 mm/s
    for (std::size_t n = 0; n < r.tool.size(); ++n) {
      const double a = std::atan2(r.tool[n].y_mm, r.tool[n].x_mm - 400.0);
      CHECK(std::abs(r.yaw_rad[n] - (a + 0.5 * std::numbers::pi)) < off);
    }
    CHECK(r.trajectory.certificate.limits.size() == 15);  // total, orientation, J1, J2, J4 and not J3
  }
}

TEST_CASE(
    "4.1: VCON, ACON, JCON and AREST keep the orientation's rate and acceleration as they keep a joint's") {
  const auto arm = make_scara(cobra600());
  const std::vector<Point2> line{{380, -40}, {380, 0}, {380, 40}};
  PathInput in{.points = line};
  PlanOptions options;
  options.method = Method::kThesis;
  const PlanResult plain = plan(in, *arm, turning_limits(), options);
  in.yaw_point_rad = {0.0, 0.5, 3.0};
  const PlanResult turning = plan(in, *arm, turning_limits(), options);
  options.method = Method::kCertified;
  const PlanResult certified = plan(in, *arm, turning_limits(), options);
  REQUIRE(turning.ok());
  CHECK(turning.continuous_s > 1.5 * plain.continuous_s);
  CHECK(turning.continuous_s == Approx(certified.continuous_s).epsilon(0.15));
  CHECK(turning.trajectory.certificate.lower_bound_s < turning.continuous_s);
  double most = 0.0;
  for (const LimitRatio& l : turning.trajectory.certificate.limits) {
    INFO(l.limit << " " << l.ratio);
    if (l.limit.ends_with("rate") || l.limit.ends_with("speed")) CHECK(l.ratio <= 1.001);
    if (l.limit.ends_with("acceleration"))
      CHECK(l.ratio <= 1.25);  // 4.2.4 has a margin of 10 %, and the yaw a kink
    if (l.limit == "orientation rate" || l.limit == "J4 rate") most = std::max(most, l.ratio);
  }
  CHECK(most > 0.97);
  const auto rate = differences(turning.yaw_rad, turning.trajectory.tick_s);
  CHECK(rate[0] <= 1.001 * turning_limits().orientation.rate);
  for (std::size_t n = 0; n < turning.tool.size(); ++n) {
    const double s = turning.tool[n].y_mm + 40.0,
                 given = s < 40.0 ? 0.5 * s / 40.0 : 0.5 + 2.5 * (s - 40.0) / 40.0;
    CHECK(std::abs(turning.yaw_rad[n] - given) <= 0.02);
  }
}

TEST_CASE(
    "A straight along which the tool turns unevenly keeps its bends as points of the default technique") {
  const auto arm = make_scara(cobra600());
  const std::vector<Point2> line{{380, -60}, {380, -20}, {380, 0}, {380, 60}};
  PathInput in{.points = line};
  in.yaw_point_rad = {0.0, 0.4, 0.6, 0.6};  // bends at the third point alone
  PlanOptions options;
  options.method = Method::kDefault;
  const PlanResult r = plan(in, *arm, cobra600_limits(), options);
  REQUIRE(r.ok());
  for (std::size_t n = 0; n < r.tool.size(); ++n) {
    const double y = r.tool[n].y_mm, given = y < 0.0 ? 0.01 * (y + 60.0) : 0.6;
    CHECK(std::abs(r.yaw_rad[n] - given) < (std::abs(y) < 10.0 ? 0.03 : 1e-6));
  }
}

TEST_CASE("A closed path returns to its first yaw by the nearest whole turn") {
  const auto arm = make_scara(cobra600());
  std::vector<Point2> circle;
  PathInput in;
  for (int i = 0; i < 200; ++i) {
    const double a = 2.0 * std::numbers::pi * i / 200;
    circle.push_back({400.0 + 15.0 * std::cos(a), 15.0 * std::sin(a)});
    in.yaw_point_rad.push_back(a);
  }
  in.points = circle;
  in.closed = true;
  const PlanResult r = plan(in, *arm, cobra600_limits());
  REQUIRE(r.ok());
  CHECK(r.yaw_rad.back() == Approx(2.0 * std::numbers::pi).margin(1e-9));
}

}  // namespace firn::motion
