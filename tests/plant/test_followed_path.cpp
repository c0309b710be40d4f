// The stage twin along a path: its servo against closed forms, its recording, its faults.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "plant/twins/path_follower.h"
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::plant;

namespace {

StageParams servo_of(double hz, double damping, double feed_forward) {
  StageParams p;
  p.servo_hz = hz;
  p.servo_damping = damping;
  p.servo_feed_forward = feed_forward;
  return p;
}

/// From rest: acceleration a_mm_s2 up to v_mm_s, so long at that speed, and to rest again; along x.
std::vector<TrackKnot> ramp_and_back(double v_mm_s, double a_mm_s2, double steady_s) {
  const double up = v_mm_s / a_mm_s2, rise = 0.5 * v_mm_s * up, far = rise + v_mm_s * steady_s;
  return {{0, 0, 0, 0, 0},
          {up, rise, 0, v_mm_s, 0},
          {up + steady_s, far, 0, v_mm_s, 0},
          {2 * up + steady_s, far + rise, 0, 0, 0}};
}

WorldConfig with_servo() {
  WorldConfig c;
  c.stage.servo_hz = 60.0;
  c.stage.servo_feed_forward = 0.9;
  c.stage.latency_us = 0;
  return c;
}

/// Sends the knots and begins; X and Y stand at the first one.
void begin_path(Bench& b, const std::vector<TrackKnot>& knots, int period_ms) {
  b.stage("WAIT MODE NOWAIT");
  b.stage("ENABLE @0");
  b.stage("ENABLE @1");
  b.stage("IGLOBAL(40)=" + std::to_string(knots.size()));
  b.stage("IGLOBAL(41)=" + std::to_string(period_ms));
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const double numbers[] = {knots[k].t_s, knots[k].x_mm, knots[k].y_mm, knots[k].vx_mm_s, knots[k].vy_mm_s};
    for (std::size_t n = 0; n < 5; ++n)
      b.stage("DGLOBAL(" + std::to_string(5 * k + n) + ")=" + std::to_string(numbers[n]));
  }
  REQUIRE(b.stage("PROGRAM RUN 1, \"FirnPath.bcx\"") == "%\n");
}

double value_of(Bench& b, const std::string& question) {
  const std::string said = b.stage(question);
  REQUIRE(said.size() > 2);
  return std::stod(said.substr(1));
}

}  // namespace

TEST_CASE(
    "The servo's steady lag is (1 - f) 2 d / w and the error of a steady acceleration a / w^2 beyond it",
    "[followed][seeded]") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    RandomStream r(seed, Purpose::kTest);
    const double hz = r.uniform(30, 120), damping = r.uniform(0.4, 1.2), f = r.uniform(0.0, 1.1),
                 v = r.uniform(2, 20), a = r.uniform(5, 40), w = 2 * std::numbers::pi * hz;
    const PathFollower path(ramp_and_back(v, a, 0.5), 0, {0.0, 0.0}, servo_of(hz, damping, f));
    const double up = v / a, lag = (1 - f) * 2 * damping / w;
    const auto behind = [&](double t, double wanted) {
      return wanted - path.position(std::llround(t * 1e6))[0];
    };
    const double steady = up + 0.45;
    CHECK(behind(steady, 0.5 * v * up + v * 0.45) == Approx(v * lag).margin(2e-5));
    const double late = up - 0.005;
    if (up > 0.1)
      CHECK(behind(late, 0.5 * a * late * late) ==
            Approx(a * late * lag + a / (w * w) - lag * 2 * damping / w * a).margin(2e-4));
    const auto end = path.position(path.end_us());
    CHECK(end[0] == Approx(v * up + v * 0.5).margin(1e-9));
    CHECK(std::abs(path.velocity(path.end_us())[0]) < 1e-12);
  }
}

TEST_CASE("Without a bandwidth the stage follows exactly, as its plan says", "[followed]") {
  const auto knots = ramp_and_back(10, 100, 0.3);
  const PathFollower path(knots, 1000, {0.0, 0.0}, StageParams{});
  const Track plan(knots, 1000);
  for (std::int64_t t = 1000; t <= plan.end_us(); t += 7919) CHECK(path.position(t) == plan.position(t));
}

TEST_CASE(
    "The controller records whole counts at whole periods, and what the host reads is where the axes were",
    "[followed]") {
  Bench b(with_servo());
  const auto knots = ramp_and_back(10, 100, 0.3);
  begin_path(b, knots, 10);
  const std::int64_t begun_us = b.now_us;
  const PathFollower truth(knots, begun_us, {0.0, 0.0}, with_servo().stage);
  b.run(205'000);
  CHECK(value_of(b, "IGLOBAL(42)") == 21);  // 0 to 200 ms
  b.run(2'000'000);
  const int n = int(value_of(b, "IGLOBAL(42)"));
  CHECK(n == int((truth.end_us() - begun_us) / 10'000) + 1);
  const std::size_t first = 5 * knots.size();
  for (int k = 0; k < n; k += 7) {
    const double x = value_of(b, "DGLOBAL(" + std::to_string(first + 2 * std::size_t(k)) + ")");
    CHECK(std::abs(x - truth.position(begun_us + 10'000 * k)[0]) <= 0.5e-4 + 1e-9);
    CHECK(std::abs(x * 1e4 - std::round(x * 1e4)) < 1e-6);
  }
}

TEST_CASE("A path that is aborted leaves the samples up to then", "[followed]") {
  Bench b(with_servo());
  begin_path(b, ramp_and_back(10, 100, 0.3), 10);
  b.run(152'000);
  b.stage("ABORT @0");
  b.run(2'000'000);
  CHECK(value_of(b, "IGLOBAL(42)") == 16);
}

TEST_CASE("A period of none records nothing", "[followed]") {
  Bench b(with_servo());
  begin_path(b, ramp_and_back(10, 100, 0.3), 0);
  b.run(2'000'000);
  CHECK(value_of(b, "IGLOBAL(42)") == 0);
}

TEST_CASE("An axis that drags falls behind and catches up when it is free again", "[followed]") {
  StageParams p = servo_of(60, 0.7, 0.9);
  PathFollower dragged(ramp_and_back(10, 500, 1.0), 0, {0.0, 0.0}, p), free = dragged;
  dragged.drag(true, 300'000, p);
  dragged.drag(false, 600'000, p);
  CHECK(dragged.position(299'000) == free.position(299'000));
  const double lag_mm = free.position(590'000)[0] - dragged.position(590'000)[0];
  CHECK(lag_mm == Approx(10 * 0.1 * 1.4 / (2 * std::numbers::pi) * (1 / 6.0 - 1 / 60.0)).epsilon(0.1));
  CHECK(dragged.position(900'000)[0] == Approx(free.position(900'000)[0]).margin(1e-4));
  CHECK(dragged.fault_us() == INT64_MAX);
}

TEST_CASE("An axis farther from its plan than the controller permits is a position error", "[followed]") {
  Bench b(with_servo());
  begin_path(b, ramp_and_back(50, 500, 1.0), 10);
  b.run(300'000);
  b.world.inject({"stage", FaultKind::kTrip, 10, 0}, b.now_us);
  b.run(100'000);
  CHECK(b.stage("AXISFAULT(@0)") == "%1\n");
  const double held = value_of(b, "PFBKPROG(@0)");
  b.run(1'000'000);
  CHECK(value_of(b, "PFBKPROG(@0)") == held);
}

TEST_CASE("A stage with a servo is saved in the middle of a path and goes on bit for bit", "[followed]") {
  StageParams p = servo_of(60, 0.7, 0.9);
  PathFollower one(ramp_and_back(10, 500, 1.0), 0, {0.0, 0.0}, p);
  one.stick_encoder(400'000, one.feedback(400'000)[0], p);
  Archive out;
  one.io(out);
  PathFollower two;
  Archive in(out.bytes());
  two.io(in);
  CHECK(two.fault_us() == one.fault_us());
  for (std::int64_t t = 0; t < one.end_us(); t += 9973) {
    CHECK(two.position(t) == one.position(t));
    CHECK(two.feedback(t) == one.feedback(t));
  }
}
