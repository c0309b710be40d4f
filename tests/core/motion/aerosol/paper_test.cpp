// --corner paper: the figures of the paper, and properties that hold for any coordinates.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/aerosol/plan.h"
#include "tests/core/motion/aerosol/jobs.h"

using namespace firn::motion;
using namespace firn::test;
using firn::Point2;
using firn::PrintJob;

namespace {

constexpr AerosolOptions kPaper{CornerMode::kPaper};
constexpr double kFeature_mm = 10.0;  // the paper gives position errors in percent of this size
const AerosolMachine kPaperMachine;

double to_rad(double deg) { return deg * std::numbers::pi / 180.0; }

// Largest errors by stepping through the plan, not by its own analysis.
struct Errors {
  double speed = 0.0, position_mm = 0.0;
};
Errors sampled_errors(const PrintJob& job, const AerosolPlan& plan, double step_s = 1e-4) {
  Errors worst;
  double begin = -1.0;
  std::int32_t segment = -1;
  for (const Piece& p : plan.pieces) {
    if (p.kind != PieceKind::kPrint) continue;
    if (p.segment != segment) {
      begin = p.t_s;
      segment = p.segment;
    }
    const firn::PrintSegment& s = job.segments[std::size_t(segment)];
    const double length = std::hypot(s.to.x_mm - s.from.x_mm, s.to.y_mm - s.from.y_mm);
    for (double t = p.t_s; t < p.t_s + p.duration_s; t += step_s) {
      const PlaneState at = state_at(plan, t);
      const double gone = s.speed_mm_s * (t - begin) / length;
      worst.speed =
          std::max(worst.speed, std::abs(std::hypot(at.v_mm_s.x_mm, at.v_mm_s.y_mm) / s.speed_mm_s - 1.0));
      worst.position_mm = std::max(worst.position_mm,
                                   std::hypot(at.p_mm.x_mm - s.from.x_mm - gone * (s.to.x_mm - s.from.x_mm),
                                              at.p_mm.y_mm - s.from.y_mm - gone * (s.to.y_mm - s.from.y_mm)));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE(
    "Erratum FIT, Fig. 10: with the fitted coordinates the speed error is 60.0 % and the position error 1.09 "
    "%",
    "[aerosol]") {
  const AerosolPlan plan = plan_aerosol(thompson_fig7(), kPaperMachine, kPaper);
  REQUIRE(plan.ok());
  CHECK(100 * plan.report.speed_error.value == Approx(60.0).margin(0.1));
  CHECK(100 * plan.report.position_error_mm.value / kFeature_mm == Approx(1.09).margin(0.1));
  CHECK(plan.report.position_error_mm.value == Approx(0.10863284343).margin(1e-6));
  const Errors sampled = sampled_errors(thompson_fig7(), plan);
  CHECK(plan.report.speed_error.value == Approx(sampled.speed).margin(1e-3));
  CHECK(plan.report.position_error_mm.value == Approx(sampled.position_mm).margin(1e-5));
  CHECK(plan.report.speed_error.value >= sampled.speed);
  CHECK(plan.report.transits == 4);
  CHECK(plan.open.size() == 3);
}

TEST_CASE(
    "Erratum FIT, Fig. 12: from 125 to 5 degrees the speed error reaches 96.8 % and the position error 1.49 "
    "%",
    "[aerosol]") {
  const AerosolPlan plan = plan_aerosol(thompson_fig11(), kPaperMachine, kPaper);
  REQUIRE(plan.ok());
  CHECK(100 * plan.report.speed_error.value == Approx(96.8).margin(0.1));
  CHECK(100 * plan.report.position_error_mm.value / kFeature_mm == Approx(1.49).margin(0.1));
  CHECK(plan.report.position_error_mm.value == Approx(0.14942998424).margin(1e-6));
  CHECK(plan.report.position_error_mm.value ==
        Approx(sampled_errors(thompson_fig11(), plan).position_mm).margin(1e-5));
}

TEST_CASE("Equations (52), (53): at a corner the speed is v sin(angle / 2), for any coordinates",
          "[aerosol]") {
  Numbers next(21);
  for (int n = 0; n < 300; ++n) {
    const double angle = next(0, 180), heading = next(0, 360);
    const PrintJob job = corner(angle, heading);
    const AerosolPlan plan = plan_aerosol(job, kPaperMachine, kPaper);
    if (!plan.ok()) continue;  // an axis that would need more than 4 mm/s
    for (const Piece& p : plan.pieces)
      if (p.kind == PieceKind::kPrint && p.segment == 1) {
        CHECK(std::hypot(p.v_mm_s.x_mm, p.v_mm_s.y_mm) ==
              Approx(3.0 * std::sin(to_rad(angle / 2))).margin(1e-7));
        break;
      }
    CHECK(plan.report.speed_error.value >= 1.0 - std::sin(to_rad(angle / 2)) - 1e-7);
  }
}

TEST_CASE("At 0 degrees the speed error is 100 %, straight on it is none, and it falls as the angle grows",
          "[aerosol]") {
  for (double heading : {0.0, 17.0, 45.0, 60.0, 90.0}) {
    CHECK(plan_aerosol(corner(0, heading), kPaperMachine, kPaper).report.speed_error.value ==
          Approx(1.0).margin(1e-7));
    CHECK(plan_aerosol(corner(180, heading), kPaperMachine, kPaper).report.speed_error.value ==
          Approx(0.0).margin(1e-7));
    double before = 1.0 + 1e-9;
    for (double angle = 0; angle <= 180; angle += 2.5) {
      const AerosolPlan plan = plan_aerosol(corner(angle, heading), kPaperMachine, kPaper);
      REQUIRE(plan.ok());
      for (const Piece& p : plan.pieces)
        if (p.kind == PieceKind::kPrint && p.segment == 1) {
          const double error = 1.0 - std::hypot(p.v_mm_s.x_mm, p.v_mm_s.y_mm) / 3.0;
          CHECK(error < before + 1e-9);
          before = error;
          break;
        }
    }
  }
}

TEST_CASE("The position error of averaged corners is at most v^2 / (2 alpha), for any coordinates",
          "[aerosol]") {
  Numbers next(22);
  int planned = 0;
  for (int n = 0; n < 400; ++n) {
    AerosolMachine machine;
    machine.axis = {next(4, 8), next(20, 60)};
    const double speed = next(1, 4), bound = speed * speed / (2 * machine.axis.alpha_mm_s2);
    const AerosolPlan plan = plan_aerosol(random_job(next, 6, 20.0, speed), machine, kPaper);
    if (!plan.ok()) continue;
    ++planned;
    CHECK(plan.report.position_error_mm.value <= bound * (1 + 1e-9));
    CHECK(plan.report.path_error_mm.value <= plan.report.position_error_mm.value * (1 + 1e-9));
  }
  CHECK(planned > 100);
}

TEST_CASE("Isolated segments are printed without any error (48), (49)", "[aerosol]") {
  PrintJob job = thompson_fig7();
  job.segments.erase(job.segments.begin(), job.segments.begin() + 3);
  const AerosolPlan plan = plan_aerosol(job, kPaperMachine, kPaper);
  REQUIRE(plan.ok());
  CHECK(plan.report.speed_error.value < 1e-9);
  CHECK(plan.report.position_error_mm.value < 1e-9);
}

TEST_CASE(
    "Erratum hairpins: below 1.6 mm the stage is too slow, below 1.2 mm there is no solution, and segment "
    "and "
    "reason are told",
    "[aerosol]") {
  const auto hairpin = [](double length) { return through({{0, 0}, {5, 0}, {5 - length, 0}, {10, 0}}); };
  const auto plan = [&](double length) { return plan_aerosol(hairpin(length), kPaperMachine, kPaper); };
  CHECK(plan(1.601).ok());
  const AerosolPlan slow = plan(1.599), none = plan(1.199), between = plan(1.201);
  REQUIRE(slow.refused.size() == 1);
  CHECK(slow.refused[0].segment == 1);
  CHECK_THAT(slow.refused[0].reason,
             Catch::Contains("axis x needs 4.0") && Catch::Contains("the stage has 4 mm/s"));
  CHECK_THAT(between.refused.at(0).reason, Catch::Contains("the stage has 4 mm/s"));
  REQUIRE(none.refused.size() == 1);
  CHECK(none.refused[0].segment == 1);
  CHECK_THAT(none.refused[0].reason,
             Catch::Contains("cannot go from 0 to 0 mm/s over -1.199 mm in 0.3997 s"));
  CHECK(none.pieces.empty());
}
