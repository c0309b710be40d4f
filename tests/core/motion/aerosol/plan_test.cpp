// Jobs, machines, refusals, the stage's trajectory.
#include "core/motion/aerosol/plan.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/motion/kinematics/fault.h"
#include "tests/core/motion/aerosol/jobs.h"

using namespace firn::motion;
using namespace firn::test;
using Catch::Matchers::Contains;
using firn::Point2;
using firn::PrintJob;
using firn::Trajectory;

namespace {
const AerosolMachine kMachine;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
}  // namespace

TEST_CASE(
    "II-B: the stage carries the substrate, so it moves minus the path, and the sign is taken when the stage "
    "is "
    "sampled",
    "[aerosol]") {
  AerosolMachine machine;
  machine.stage_origin = {50, 60};
  const AerosolPlan plan = plan_aerosol(thompson_fig7(), machine);
  const Trajectory carried = sample_stage(plan, machine);
  machine.substrate_moves = false;
  const Trajectory nozzle = sample_stage(plan, machine);
  REQUIRE(carried.samples() == nozzle.samples());
  for (std::size_t n = 0; n < carried.positions.size(); n += 2) {
    CHECK(carried.positions[n] + nozzle.positions[n] == Approx(100.0));
    CHECK(carried.positions[n + 1] + nozzle.positions[n + 1] == Approx(120.0));
  }
  CHECK(carried.positions[0] == 50.0);
  CHECK(carried.positions[1] == 50.0);  // 60 - 10
  CHECK(nozzle.positions[nozzle.positions.size() - 2] == Approx(50.0));
  CHECK(nozzle.positions.back() == Approx(60.0));
}

TEST_CASE("The sampled stage obeys the limits: differences of the samples, from rest to rest", "[aerosol]") {
  for (CornerMode mode : {CornerMode::kPaper, CornerMode::kLoop, CornerMode::kHybrid}) {
    const AerosolPlan plan = plan_aerosol(thompson_fig11(), kMachine, {mode});
    REQUIRE(plan.ok());
    const Trajectory out = sample_stage(plan, kMachine);
    CHECK(out.axes == 2);
    CHECK(double(out.samples() - 1) * out.tick_s >= plan.duration_s() - 1e-9);
    CHECK(double(out.samples() - 2) * out.tick_s < plan.duration_s());
    for (std::size_t axis = 0; axis < 2; ++axis)
      for (std::size_t n = 2; n < out.samples(); ++n) {
        const double a = out.positions[2 * n - 4 + axis], b = out.positions[2 * n - 2 + axis],
                     c = out.positions[2 * n + axis];
        CHECK(std::abs(c - b) / out.tick_s <= 4.0 * (1 + 1e-6));
        CHECK(std::abs(c - 2 * b + a) / (out.tick_s * out.tick_s) <= 30.0 * (1 + 1e-5));
      }
    for (const firn::LimitRatio& limit : out.certificate.limits) CHECK(limit.ratio <= 1 + 1e-9);
    CHECK(out.certificate.duration_s >= out.certificate.lower_bound_s - 1e-9);
  }
}

TEST_CASE("Every segment that cannot be done is refused by number with its reason, and nothing is planned",
          "[aerosol]") {
  PrintJob job = thompson_fig7();
  job.segments[1].speed_mm_s = -3;
  job.segments[3].to = job.segments[3].from;
  job.segments[4].speed_mm_s = 5;
  job.segments.push_back({{0, kNone}, {1, 1}, 3});
  const AerosolPlan plan = plan_aerosol(job, kMachine);
  REQUIRE(plan.refused.size() == 4);
  CHECK(plan.refused[0].segment == 1);
  CHECK_THAT(plan.refused[0].reason, Contains("speed -3 mm/s is not positive"));
  CHECK(plan.refused[1].segment == 3);
  CHECK_THAT(plan.refused[1].reason, Contains("no length: both ends are (0, 8) mm"));
  CHECK(plan.refused[2].segment == 4);
  CHECK_THAT(plan.refused[2].reason, Contains("axis x needs 5 mm/s, the stage has 4 mm/s"));
  CHECK(plan.refused[3].segment == 5);
  CHECK_THAT(plan.refused[3].reason, Contains("not finite"));
  CHECK(plan.pieces.empty());
  CHECK(sample_stage(plan, kMachine).samples() == 0);
  job = thompson_fig7();
  job.start.x_mm = kNone;
  CHECK_THAT(plan_aerosol(job, kMachine).refused.at(0).reason, Contains("start point is not finite"));
}

TEST_CASE("A loop that would leave the stage's range is refused", "[aerosol]") {
  AerosolMachine machine;
  machine.stage_low = {-9.5, -11};
  machine.stage_high = {1, 1};  // the corner at x = 9 overshoots
  CHECK(plan_aerosol(thompson_fig7(), machine).ok());
  machine.stage_low.x_mm = -9.02;
  const AerosolPlan narrow = plan_aerosol(thompson_fig7(), machine);
  REQUIRE(narrow.refused.size() >= 1);
  CHECK(narrow.refused[0].segment == 1);
  CHECK_THAT(narrow.refused[0].reason,
             Contains("the stage's x would go to -9.") && Contains("its range is -9.02 to 1 mm"));
}

TEST_CASE("A machine without limits or an impossible tolerance is named", "[aerosol]") {
  const auto with = [](auto change) {
    AerosolMachine machine;
    change(machine);
    plan_aerosol(thompson_fig7(), machine);
  };
  CHECK_THROWS_WITH(with([](AerosolMachine& m) { m.axis.alpha_mm_s2 = 0; }), Contains("acceleration_mm_s2"));
  CHECK_THROWS_WITH(with([](AerosolMachine& m) { m.axis.v_max_mm_s = kNone; }), Contains("v_max_mm_s"));
  CHECK_THROWS_WITH(with([](AerosolMachine& m) { m.tick_s = -1; }), Contains("tick_s"));
  CHECK_THROWS_WITH(with([](AerosolMachine& m) { m.shutter_delay_s = -1; }), Contains("shutter_delay_s"));
  CHECK_THROWS_AS(plan_aerosol(thompson_fig7(), kMachine, {CornerMode::kHybrid, kNone}), MotionError);
}

TEST_CASE("A job without segments is one transit, and wasted flow is the flow times the closed time",
          "[aerosol]") {
  AerosolMachine machine;
  machine.flow_mm3_s = 0.02;
  const AerosolPlan empty = plan_aerosol({{0, 10}, {0, 0}, {}}, machine);
  REQUIRE(empty.ok());
  CHECK(empty.open.empty());
  CHECK(empty.report.total_s == Approx(10.0 / 4 + 4.0 / 30));
  const AerosolPlan fig7 = plan_aerosol(thompson_fig7(), machine);
  CHECK(fig7.report.wasted_mm3 == Approx(0.02 * fig7.report.transit_s));
  const AerosolPlan standing = plan_aerosol({{1, 1}, {1, 1}, {}}, machine);
  CHECK(standing.duration_s() == 0.0);
}
