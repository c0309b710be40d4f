#include <catch2/catch.hpp>

#include <cmath>
#include <complex>
#include <numbers>

#include "plant/ice/arm.h"
#include "tests/support/ice_paths.h"

using namespace firn::plant;

TEST_CASE("The cantilever rings at its frequency and dies away at its damping after the flange has stopped") {
  const double hz = 12.0, zeta = 0.03, step_s = 0.004, w = 2.0 * std::numbers::pi * hz;
  const SecondOrder flex(hz, zeta, true, step_s);
  SecondOrder::State s = flex.at_rest(0.0);
  const double speed = 100.0, travel = 20.0;
  double u = 0.0;
  while (u < travel) {
    const double next = std::min(travel, u + speed * step_s);
    s = flex.next(s, u, next);
    u = next;
  }
  // Free from here: x = 20 + Re(A exp((-zeta w + i w_d) t)).
  const double w_d = w * std::sqrt(1.0 - zeta * zeta), v0 = flex.velocity(s, u), x0 = s.x - travel;
  const std::complex<double> rate(-zeta * w, w_d), amplitude(x0, -(v0 + zeta * w * x0) / w_d);
  for (int n = 1; n <= 500; ++n) {
    s = flex.next(s, travel, travel);
    REQUIRE(s.x - travel == Approx((amplitude * std::exp(rate * (n * step_s))).real()).margin(1e-9));
  }
}

TEST_CASE("A servo follows a ramp 2 zeta / w late and stands where it was sent") {
  const SecondOrder servo(20.0, 1.0, false, 0.004);
  const double late_s = 2.0 / (2.0 * std::numbers::pi * 20.0), speed = 0.5;
  SecondOrder::State s = servo.at_rest(0.0);
  for (int n = 0; n < 250; ++n) s = servo.next(s, speed * n * 0.004, speed * (n + 1) * 0.004);
  CHECK(s.x == Approx(speed * (1.0 - late_s)).epsilon(1e-9));
  for (int n = 0; n < 250; ++n) s = servo.next(s, 0.5, 0.5);
  CHECK(s.x == Approx(0.5).epsilon(1e-9));
}

TEST_CASE("The end effector deflects by a / w^2 under the acceleration limit of the thesis") {
  IceArmParams p;
  p.clock_ppm = 0.0;
  TrueArm arm(p);
  std::vector<Joints> points;  // straight out along x at 500 mm/s^2: y from the inverse kinematics
  for (int n = 0; n <= 30; ++n) {
    const double t = n * 0.016;
    points.push_back(ice_paths::joints_of(p, {}, {250.0 * t * t, 0.0}, 50.0));
  }
  arm.place(points.front());
  arm.follow(points, 0.016, 0.0);
  double sum = 0.0;
  int count = 0;
  const double w = 2.0 * std::numbers::pi * p.servo_hz, late_s = 2.0 * p.servo_damping / w;
  arm.run_until(0.48, [&](double t_s, const ArmPose& pose) {
    if (t_s < 0.2 || t_s > 0.45)
      return;  // the servo is late by 2 zeta / w, and by a / w^2 (4 zeta^2 - 1) less
    const double behind = 250.0 * (t_s - late_s) * (t_s - late_s) +
                          500.0 * (2.0 * p.servo_damping * p.servo_damping - 1.0) / (w * w);
    sum += pose.x_mm - behind;
    ++count;
  });
  const double flex = 2.0 * std::numbers::pi * p.cantilever_hz;
  CHECK(sum / count == Approx(-500.0 / (flex * flex)).margin(0.03));
}

TEST_CASE("Clocks of robot and valve drift 5 ms apart over the longest path") {
  const IceWorldConfig c;
  TrueArm arm(c.arm);
  std::vector<Joints> points(8193, Joints{0.1, 1.2, 100.0, -1.3});
  arm.place(points.front());
  arm.follow(points, 0.016, 0.0);
  const double robot_s = arm.end_s(), valve_s = 65536 * 0.002 * (1.0 + c.valve[0].clock_ppm * 1e-6);
  CHECK(robot_s == Approx(131.072 * (1.0 + c.arm.clock_ppm * 1e-6)).epsilon(1e-12));
  CHECK(robot_s - valve_s == Approx(0.005).margin(0.0005));
}

TEST_CASE("Encoders show whole counts of Table 2-1") {
  const IceArmParams p;
  TrueArm arm(p);
  arm.place({0.123456789, 1.0, 77.77777, -1.1});
  const Joints q = arm.encoders();
  CHECK(std::abs(q[0] - 0.123456789) <= 0.5 * 0.00045 * std::numbers::pi / 180.0);
  CHECK(q[2] / 0.0015 == Approx(std::round(77.77777 / 0.0015)));
}

TEST_CASE("Braking brings the arm to rest on its path within the stated time") {
  IceArmParams p;
  TrueArm arm(p);
  const auto run = ice_paths::along(
      p, {}, {{-40.0, 0.0}, {40.0, 0.0}}, 50.0, 100.0, 1.5, [](double) { return 0.25; }, 0.0);
  arm.place(run.points.front());
  arm.follow(run.points, 0.016, 0.0);
  arm.run_until(0.5, nullptr);
  const double x_before = arm.newest().x_mm;
  arm.brake(p.brake_s);
  arm.run_until(0.5 + p.brake_s + 0.008, nullptr);
  CHECK_FALSE(arm.commanded());
  arm.run_until(6.0, nullptr);
  CHECK(arm.still());
  CHECK(arm.newest().x_mm - x_before > 1.0);
  CHECK(arm.newest().x_mm - x_before < 100.0 * (p.brake_s + 0.02));
  CHECK(std::abs(arm.newest().y_mm) < 0.05);
}
