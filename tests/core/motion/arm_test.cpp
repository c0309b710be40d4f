#include "core/motion/kinematics/arm.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/grid/random.h"
#include "core/motion/kinematics/limits.h"

using namespace firn;
using namespace firn::motion;

namespace {

constexpr double kPi = std::numbers::pi;

/// A smooth curve in time with known derivatives: an ellipse, rising and turning the tool.
struct ArmCurve {
  double cx, cy, rx, ry, w, z, yaw, yaw_rate;
  TaskVector at(double t, int order) const {
    const double phase = w * t + order * kPi / 2, scale = std::pow(w, order);
    return {(order ? 0 : cx) + rx * scale * std::cos(phase), (order ? 0 : cy) + ry * scale * std::sin(phase),
            order == 0   ? z + t
            : order == 1 ? 1.0
                         : 0.0,
            order == 0   ? yaw + yaw_rate * t
            : order == 1 ? yaw_rate
                         : 0.0};
  }
  Jets jets(std::size_t n, double dt) const {
    Jets jets(kTaskAxes, n);
    for (std::size_t i = 0; i < n; ++i)
      for (int order = 0; order < 4; ++order)
        for (int axis = 0; axis < kTaskAxes; ++axis)
          jets.of(axis, order)[i] = at(double(i) * dt, order)[std::size_t(axis)];
    return jets;
  }
};

ArmCurve random_curve(RandomStream& random) {
  const double reach = random.uniform(260.0, 500.0), angle = random.uniform(-1.2, 1.2);
  return {reach * std::cos(angle),   reach * std::sin(angle),  random.uniform(2.0, 60.0),
          random.uniform(2.0, 60.0), random.uniform(0.2, 2.0), random.uniform(1.0, 200.0),
          random.uniform(-1.0, 1.0), random.uniform(-0.5, 0.5)};
}

Jets poses(const std::vector<TaskVector>& list) {
  Jets jets(kTaskAxes, list.size());
  for (std::size_t i = 0; i < list.size(); ++i)
    for (int axis = 0; axis < kTaskAxes; ++axis) jets.of(axis, 0)[i] = list[i][std::size_t(axis)];
  return jets;
}

}  // namespace

TEST_CASE("Forward kinematics of the inverse give the pose back for both elbows") {
  const auto arm = make_scara(cobra600());
  RandomStream random(1, Purpose::kTest);
  int solved = 0;
  for (int i = 0; i < 20000; ++i) {
    const double reach = random.uniform(170.0, 599.99), angle = random.uniform(-2.0, 2.0);
    const TaskVector pose{reach * std::cos(angle), reach * std::sin(angle), random.uniform(0, 210),
                          random.uniform(-1.0, 1.0)};
    for (const int elbow : {-1, 1}) {
      try {
        const JointVector q = arm->inverse(pose, {elbow, 0});
        const TaskVector back = arm->forward(q);
        for (std::size_t axis = 0; axis < kTaskAxes; ++axis)
          REQUIRE(std::abs(back[axis] - pose[axis]) < 1e-9);
        REQUIRE(q[1] * elbow > 0);
        ++solved;
      } catch (const MotionError& e) {
        const bool joint = e.fault().reason == Reason::kJointLow || e.fault().reason == Reason::kJointHigh;
        REQUIRE(joint);  // inside the annulus only a joint's range can stand in the way
      }
    }
  }
  CHECK(solved > 20000);
}

TEST_CASE("The wrist keeps the tool's yaw: theta_4 = phi - theta_1 - theta_2 (4.11)") {
  const auto arm = make_scara(cobra600());
  const JointVector q = arm->inverse({400, 100, 20, 0.3}, {1, 0});
  CHECK(q[3] == Approx(0.3 - q[0] - q[1]).margin(1e-15));
  CHECK(arm->inverse({400, 100, 20, 0.3}, {1, 1})[3] == Approx(q[3] + 2 * kPi));
}

TEST_CASE("Joint derivatives to third order agree with differences of the inverse") {
  const auto arm = make_scara(cobra600());
  RandomStream random(2, Purpose::kTest);
  const double dt = 2e-3;
  for (int trial = 0; trial < 200; ++trial) {
    const ArmCurve curve = random_curve(random);
    const ArmConfiguration configuration{trial % 2 ? 1 : -1, 0};
    Jets joints(4, 9);
    if (arm->inverse(curve.jets(9, dt), configuration, joints)) continue;
    for (int joint = 0; joint < 4; ++joint)
      for (int order = 0; order < 3; ++order) {  // fourth-order central difference of each derivative
        const double* f = joints.of(joint, order);
        const double slope = (f[2] - 8 * f[3] + 8 * f[5] - f[6]) / (12 * dt);
        REQUIRE(joints.of(joint, order + 1)[4] == Approx(slope).epsilon(1e-6).margin(1e-7));
      }
  }
}

TEST_CASE("Forward derivatives undo the inverse's to third order") {
  const auto arm = make_scara(cobra600());
  RandomStream random(3, Purpose::kTest);
  for (int trial = 0; trial < 300; ++trial) {
    const ArmCurve curve = random_curve(random);
    const Jets task = curve.jets(5, 0.01);
    Jets joints(4, 5), back(kTaskAxes, 5);
    if (arm->inverse(task, {1, 0}, joints)) continue;
    arm->forward(joints, back);
    for (int axis = 0; axis < kTaskAxes; ++axis)
      for (int order = 0; order < 4; ++order)
        for (int i = 0; i < 5; ++i)
          REQUIRE(back.of(axis, order)[i] == Approx(task.of(axis, order)[i]).epsilon(1e-9).margin(1e-8));
  }
}

TEST_CASE("The Jacobian maps joint rates to the tool's velocity and its derivative to its acceleration") {
  const auto arm = make_scara(cobra600());
  RandomStream random(4, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    const Jets task = random_curve(random).jets(1, 0.01);
    Jets q(4, 1);
    if (arm->inverse(task, {1, 0}, q)) continue;
    JointVector position{}, rate{};
    for (int j = 0; j < 4; ++j) {
      position[std::size_t(j)] = q.of(j, 0)[0];
      rate[std::size_t(j)] = q.of(j, 1)[0];
    }
    const auto jacobian = arm->jacobian(position), change = arm->jacobian_rate(position, rate);
    for (int axis = 0; axis < kTaskAxes; ++axis) {
      double velocity = 0, acceleration = 0;
      for (int j = 0; j < 4; ++j) {
        velocity += jacobian[std::size_t(axis)][std::size_t(j)] * q.of(j, 1)[0];
        acceleration += jacobian[std::size_t(axis)][std::size_t(j)] * q.of(j, 2)[0] +
                        change[std::size_t(axis)][std::size_t(j)] * q.of(j, 1)[0];
      }
      REQUIRE(velocity == Approx(task.of(axis, 1)[0]).epsilon(1e-10).margin(1e-9));
      REQUIRE(acceleration == Approx(task.of(axis, 2)[0]).epsilon(1e-10).margin(1e-8));
    }
  }
}

TEST_CASE("Table 2-1: the Cobra 600 reaches from 163 mm to 600 mm and its joints stop where the table says") {
  const auto arm = make_scara(cobra600());
  CHECK_NOTHROW(arm->inverse({163.0, 0, 0, 0}, {1, 0}));
  CHECK_NOTHROW(arm->inverse({599.999, 0, 0, 0}, {1, 0}));
  const auto reason = [&](const TaskVector& pose, ArmConfiguration configuration = {1, 0}) {
    try {
      arm->inverse(pose, configuration);
      return std::string("none");
    } catch (const MotionError& e) {
      return std::string(name(e.fault().reason)) + " " + std::to_string(e.fault().axis);
    }
  };
  CHECK(reason({162.0, 0, 0, 0}) == "joint high 1");
  CHECK(reason({162.0, 0, 0, 0}, {-1, 0}) == "joint low 1");
  CHECK(reason({600.001, 0, 0, 0}) == "reach far -1");
  CHECK(reason({600.0, 0, 0, 0}) == "singular 1");
  CHECK(reason({30.0, 0, 0, 0}) == "reach near -1");
  CHECK(reason({0.0, 0, 0, 0}) == "reach near -1");
  CHECK(reason({-400.0, -10.0, 0, 0}) == "joint high 0");
  CHECK(reason({400.0, 0, -0.1, 0}) == "joint low 2");
  CHECK(reason({400.0, 0, 210.1, 0}) == "joint high 2");
  CHECK(reason({400.0, 0, 0, 8.0}) == "joint high 3");
  CHECK(reason({std::numeric_limits<double>::quiet_NaN(), 0, 0, 0}) == "not finite -1");
}

TEST_CASE("A fault names the point of the batch where the path first leaves the workspace") {
  const auto arm = make_scara(cobra600());
  std::vector<TaskVector> line;
  for (int i = 0; i <= 100; ++i) line.push_back({550.0 + i, 0, 0, 0});
  Jets joints(2, line.size());
  const auto fault = arm->inverse(poses(line), {1, 0}, joints);
  REQUIRE(fault);
  CHECK(fault->index == 50);
  CHECK(fault->at.x_mm == 600.0);
  CHECK(describe(*fault).find("singular") != std::string::npos);
}

TEST_CASE("The elbow is chosen once per path: the preferred one where it can, the other where it must") {
  const auto arm = make_scara(cobra600());
  ArmConfiguration chosen;
  REQUIRE_FALSE(arm->choose_configuration(poses({{400, -50, 0, 0}, {400, 50, 0, 0}}), {-1, 0}, chosen));
  CHECK(chosen.elbow == -1);
  // Far to the left only theta_2 > 0 keeps J1 within 105 degrees.
  const double angle = 120.0 * kPi / 180.0;
  const auto left = poses({{500 * std::cos(angle), 500 * std::sin(angle), 0, 0}});
  REQUIRE_FALSE(arm->choose_configuration(left, {-1, 0}, chosen));
  CHECK(chosen.elbow == 1);
  const auto behind = poses({{-500, 0, 0, 0}});
  const auto fault = arm->choose_configuration(behind, {1, 0}, chosen);
  REQUIRE(fault);
  CHECK(fault->axis == 0);
}

TEST_CASE("The wrist is unwound by whole turns and a path that needs more than its 720 degrees is refused") {
  const auto arm = make_scara(cobra600());
  ArmConfiguration chosen;
  REQUIRE_FALSE(arm->choose_configuration(poses({{400, 0, 0, 8.0}}), {1, 0}, chosen));
  CHECK(chosen.yaw_turns == -1);
  REQUIRE_FALSE(arm->choose_configuration(poses({{400, 0, 0, 40.0}}), {1, -6}, chosen));
  CHECK(chosen.yaw_turns == -6);
  std::vector<TaskVector> spin;
  const JointVector q = arm->inverse({400, 0, 0, 0}, {1, 0});
  for (int i = 0; i <= 200; ++i) spin.push_back({400, 0, 0, q[0] + q[1] + 2.02 * 2 * kPi * i / 200});
  const auto fault = arm->choose_configuration(poses(spin), {1, 0}, chosen);
  REQUIRE(fault);
  CHECK(fault->reason == Reason::kDespin);
  CHECK(fault->axis == 3);
  spin.resize(190);
  CHECK_FALSE(arm->choose_configuration(poses(spin), {1, 0}, chosen));
}

TEST_CASE("A stage's joints are its axes, with ranges that name the axis") {
  const auto arm = make_stage({{{0, 100}, {0, 50}}});
  const JointVector q = arm->inverse({10, 20, 5, 0}, {});
  CHECK(q[0] == 10);
  CHECK(q[1] == 20);
  CHECK(arm->joints() == 2);
  CHECK(arm->joint_name(1) == "y");
  CHECK_THROWS_WITH(arm->inverse({10, 51, 0, 0}, {}),
                    Catch::Contains("joint high") && Catch::Contains("joint 2"));
  CHECK_THROWS_AS(make_stage({{{0, 100}}}), MotionError);
  CHECK_THROWS_AS(make_stage({{{0, 100}, {5, 5}}}), MotionError);
}

TEST_CASE("Limits that are zero, negative or NaN are refused by name") {
  MotionLimits limits = cobra600_limits();
  CHECK_NOTHROW(check_limits(limits, 4));
  CHECK(limited_joints(limits, 4) == 2);
  CHECK(limits.joint[1].jerk == Approx(1560 * kPi / 180));
  limits.joint[1].acceleration = 0.0;
  CHECK_THROWS_WITH(check_limits(limits, 4),
                    Catch::Contains("joint acceleration") && Catch::Contains("joint 2"));
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    limits = cobra600_limits();
    limits.position.jerk = bad;
    CHECK_THROWS_WITH(check_limits(limits, 4), Catch::Contains("total position jerk"));
  }
  ScaraConfig spec = cobra600();
  spec.link_2_mm = 0;
  CHECK_THROWS_AS(make_scara(spec), MotionError);
}
