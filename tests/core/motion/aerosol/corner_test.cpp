// --corner loop and hybrid.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/aerosol/plan.h"
#include "core/motion/aerosol/rounding.h"
#include "tests/core/motion/aerosol/jobs.h"

using namespace firn::motion;
using namespace firn::test;
using firn::Point2;
using firn::PrintJob;

namespace {

const AerosolMachine kCornerMachine;
constexpr AerosolOptions kLoop{CornerMode::kLoop};

// Closed form of the least time in which one axis with |a| <= alpha comes back to where it is, from v0 to v1
// != v0.
double least_loop_s(double v0, double v1, double alpha) {
  return (std::abs(v0 + v1) + std::sqrt(2 * (v0 * v0 + v1 * v1))) / alpha;
}
// Both axes at once: an axis whose speed does not change comes back at once or after 4 v / alpha.
double least_corner_s(const Point2& v0, const Point2& v1, double alpha) {
  return std::max(least_loop_s(v0.x_mm, v1.x_mm, alpha), least_loop_s(v0.y_mm, v1.y_mm, alpha));
}

struct LoopSeen {
  std::int32_t segment;
  double duration_s;
  Point2 v0, v1;
};
std::vector<LoopSeen> loops(const AerosolPlan& plan) {
  std::vector<LoopSeen> seen;
  for (const Piece& p : plan.pieces) {
    if (p.kind != PieceKind::kLoop) continue;
    if (seen.empty() || seen.back().segment != p.segment) seen.push_back({p.segment, 0.0, p.v_mm_s, {}});
    seen.back().duration_s += p.duration_s;
    seen.back().v1 = {p.v_mm_s.x_mm + p.a_mm_s2.x_mm * p.duration_s,
                      p.v_mm_s.y_mm + p.a_mm_s2.y_mm * p.duration_s};
  }
  return seen;
}

void check_continuous(const AerosolPlan& plan, const PrintJob& job, const AerosolMachine& machine) {
  double t = 0.0;
  Point2 p = job.start, v;
  for (const Piece& piece : plan.pieces) {
    CHECK(piece.t_s == Approx(t).margin(1e-9));
    CHECK(std::hypot(piece.p_mm.x_mm - p.x_mm, piece.p_mm.y_mm - p.y_mm) < 1e-7);
    CHECK(std::hypot(piece.v_mm_s.x_mm - v.x_mm, piece.v_mm_s.y_mm - v.y_mm) < 1e-5);
    CHECK(std::max(std::abs(piece.a_mm_s2.x_mm), std::abs(piece.a_mm_s2.y_mm)) <=
          machine.axis.alpha_mm_s2 * (1 + 1e-9));
    t = piece.t_s + piece.duration_s;
    const PlaneState end = state_at(plan, std::nextafter(t, 0.0));
    p = end.p_mm;
    v = end.v_mm_s;
  }
  CHECK(std::hypot(p.x_mm - job.end.x_mm, p.y_mm - job.end.y_mm) < 1e-7);
  CHECK(std::hypot(v.x_mm, v.y_mm) < 1e-6);
}

}  // namespace

TEST_CASE(
    "With loops the speed error is at most 0.1 % and the position error at most 1 um while the shutter is "
    "open",
    "[aerosol]") {
  for (const PrintJob& job : {thompson_fig7(), thompson_fig11()}) {
    const AerosolPlan plan = plan_aerosol(job, kCornerMachine, kLoop);
    REQUIRE(plan.ok());
    CHECK(plan.report.speed_error.value <= 1e-3);
    CHECK(plan.report.position_error_mm.value <= 1e-3);
    check_continuous(plan, job, kCornerMachine);
  }
  Numbers next(31);
  for (int n = 0; n < 200; ++n) {
    const PrintJob job = random_job(next, 8, n % 2 ? 10.0 : 0.4, next(0.5, 4.0));
    const AerosolPlan plan = plan_aerosol(job, kCornerMachine, kLoop);
    REQUIRE(plan.ok());
    CHECK(plan.report.speed_error.value <= 1e-3);
    CHECK(plan.report.position_error_mm.value <= 1e-3);
    CHECK(plan.report.axis_speed_ratio.value <= 1 + 1e-9);
    CHECK(plan.report.axis_acceleration_ratio.value <= 1 + 1e-9);
    check_continuous(plan, job, kCornerMachine);
  }
}

TEST_CASE(
    "A loop takes the least common time of the closed form, and never more than 4 v / alpha + 2 shutter "
    "delays",
    "[aerosol]") {
  Numbers next(32);
  int seen = 0, delayed = 0;
  for (int n = 0; n < 500; ++n) {
    AerosolMachine machine;
    machine.shutter_delay_s = n % 2 ? next(0.0, 0.2) : 0.0;
    const double speed = next(0.5, 4.0), alpha = machine.axis.alpha_mm_s2;
    const AerosolPlan plan = plan_aerosol(random_job(next, 6, 5.0, speed), machine, kLoop);
    REQUIRE(plan.ok());
    for (const LoopSeen& loop : loops(plan)) {
      ++seen;
      const double least = std::max(least_corner_s(loop.v0, loop.v1, alpha), 2 * machine.shutter_delay_s);
      delayed += least == 2 * machine.shutter_delay_s;
      CHECK(loop.duration_s <= 1.001 * least + 1e-9);
      CHECK(loop.duration_s >= least - 1e-9);
      CHECK(loop.duration_s <= 4 * speed / alpha + 2 * machine.shutter_delay_s + 1e-9);
    }
  }
  CHECK(seen > 500);
  CHECK(delayed > 20);
}

TEST_CASE(
    "A hairpin's loop is braking and coming back, 2 v / alpha, and a mirrored axis needs the whole 4 v / "
    "alpha",
    "[aerosol]") {
  const auto corner_s = [](double angle, double heading) {
    return plan_aerosol(corner(angle, heading), kCornerMachine, kLoop).report.corner_s.value;
  };
  CHECK(corner_s(0, 0) == Approx(2 * 3.0 / 30));
  CHECK(corner_s(90, 0) == Approx((1 + std::sqrt(2.0)) * 3.0 / 30));
  CHECK(corner_s(150, -15) == Approx(4 * 3.0 * std::cos(15 * std::numbers::pi / 180) / 30));
}

TEST_CASE("The shutter's spans are the printed segments, and its commands come one delay earlier",
          "[aerosol]") {
  AerosolMachine machine;
  machine.shutter_delay_s = 0.03;
  const PrintJob job = thompson_fig7();
  const AerosolPlan plan = plan_aerosol(job, machine, kLoop);
  REQUIRE(plan.open.size() == 5);
  double open = 0, closed_at = 0;
  for (const firn::ShutterSpan& span : plan.open) {
    open += span.close_s - span.open_s;
    CHECK(span.open_s - closed_at >= (closed_at == 0 ? 0.03 : 0.06) - 1e-12);
    closed_at = span.close_s;
    for (double t = span.open_s; t < span.close_s; t += 0.01) {
      double nearest = 1e9;
      for (const firn::PrintSegment& s : job.segments) {
        const double dx = s.to.x_mm - s.from.x_mm, dy = s.to.y_mm - s.from.y_mm, l = std::hypot(dx, dy);
        const Point2 p = state_at(plan, t).p_mm;
        const double along = ((p.x_mm - s.from.x_mm) * dx + (p.y_mm - s.from.y_mm) * dy) / l;
        if (along > -1e-6 && along < l + 1e-6)
          nearest =
              std::min(nearest, std::abs((p.x_mm - s.from.x_mm) * dy - (p.y_mm - s.from.y_mm) * dx) / l);
      }
      CHECK(nearest < 1e-6);
    }
  }
  double lengths = 0;
  for (const firn::PrintSegment& s : job.segments)
    lengths += std::hypot(s.to.x_mm - s.from.x_mm, s.to.y_mm - s.from.y_mm);
  CHECK(open == Approx(lengths / 3.0));
  CHECK(plan.report.print_s == Approx(open));
  CHECK(plan.report.print_s + plan.report.transit_s == Approx(plan.report.total_s));
  const auto commands = shutter_commands(plan, machine);
  REQUIRE(commands.size() == 10);
  CHECK(commands[0].t_s >= 0.0);
  CHECK(commands[0].t_s == Approx(plan.open[0].open_s - 0.03));
  for (std::size_t n = 1; n < commands.size(); ++n) {
    CHECK(commands[n].open != commands[n - 1].open);
    CHECK(commands[n].t_s - commands[n - 1].t_s >= 0.03 - 1e-9);
  }
}

TEST_CASE("Slight turns round within 1 um with the shutter open, and a change of speed never does",
          "[aerosol]") {
  const AerosolPlan slight = plan_aerosol(corner(175, 20), kCornerMachine, kLoop);
  CHECK(slight.report.loops == 0);
  CHECK(slight.report.rounded == 1);
  CHECK(slight.open.size() == 1);
  PrintJob faster = corner(180, 20);
  faster.segments[1].speed_mm_s = 2.0;
  const AerosolPlan loop = plan_aerosol(faster, kCornerMachine, kLoop);
  CHECK(loop.report.loops == 1);
  CHECK(loop.report.speed_error.value < 1e-9);
}

TEST_CASE("Where speeds may blend, two of one straight line meet at their mean, within 1 um of it",
          "[aerosol]") {
  PrintJob faster = corner(180, 20);
  faster.segments[1].speed_mm_s = 2.0;
  const AerosolPlan plan = plan_aerosol(faster, kCornerMachine, {CornerMode::kLoop, 0.05, true});
  CHECK(plan.report.loops == 0);
  CHECK(plan.open.size() == 1);
  CHECK(plan.report.path_error_mm.value < 0.001);
  CHECK(plan_aerosol(corner(90, 20), kCornerMachine, {CornerMode::kLoop, 0.05, true}).report.loops == 1);
}

TEST_CASE("Hybrid keeps the tolerance, the speed and the acceleration, and is never slower than loops",
          "[aerosol]") {
  Numbers next(33);
  int rounded = 0, looped = 0;
  for (int n = 0; n < 300; ++n) {
    const double speed = next(0.5, 4.0), tolerance = next(0.0, 0.1);
    PrintJob job =
        n % 2 ? random_job(next, 6, 5.0, speed) : corner(next(0, 180), next(0, 360), next(0.05, 3.0), speed);
    const AerosolPlan hybrid = plan_aerosol(job, kCornerMachine, {CornerMode::kHybrid, tolerance}),
                      loop = plan_aerosol(job, kCornerMachine, kLoop);
    REQUIRE(hybrid.ok());
    rounded += hybrid.report.rounded;
    looped += hybrid.report.loops;
    CHECK(hybrid.report.path_error_mm.value <= std::max(tolerance, 1e-3) + 1e-9);
    CHECK(hybrid.report.speed_error.value <= 1e-3);
    CHECK(hybrid.report.axis_acceleration_ratio.value <= 1 + 1e-9);
    CHECK(hybrid.report.total_s <= loop.report.total_s + 1e-9);
    CHECK(hybrid.report.transit_s <= loop.report.transit_s + 1e-9);
    check_continuous(hybrid, job, kCornerMachine);
  }
  CHECK(rounded > 100);
  CHECK(looped > 100);
}

TEST_CASE("A rounding joins both segments, tangent, at the stage's acceleration, symmetric about the corner",
          "[aerosol]") {
  for (double turn_deg : {0.5, 10.0, 45.0, 62.0, 120.0, -45.0, -100.0})
    for (double heading : {0.0, 33.0, 200.0}) {
      const double a = heading * std::numbers::pi / 180, b = a + turn_deg * std::numbers::pi / 180;
      const Point2 from{std::cos(a), std::sin(a)}, to{std::cos(b), std::sin(b)};
      const Rounding r = round_corner(from, to, 3.0, 30.0);
      REQUIRE_FALSE(r.pieces.empty());
      CHECK(std::hypot(r.pieces[0].p_mm.x_mm, r.pieces[0].p_mm.y_mm) == Approx(r.tangent_mm));
      const Piece& last = r.pieces.back();
      const double d = last.duration_s;
      const Point2 end{last.p_mm.x_mm + d * (last.v_mm_s.x_mm + 0.5 * d * last.a_mm_s2.x_mm),
                       last.p_mm.y_mm + d * (last.v_mm_s.y_mm + 0.5 * d * last.a_mm_s2.y_mm)};
      CHECK(end.x_mm == Approx(r.tangent_mm * to.x_mm).margin(1e-12));
      CHECK(end.y_mm == Approx(r.tangent_mm * to.y_mm).margin(1e-12));
      for (const Piece& p : r.pieces) {
        CHECK(std::hypot(p.a_mm_s2.x_mm, p.a_mm_s2.y_mm) == Approx(30.0));
        CHECK(std::hypot(p.p_mm.x_mm, p.p_mm.y_mm) >= r.deviation_mm - 1e-12);
      }
      // An arc of radius v^2 / alpha is the limit of ever shorter blends.
      const double half = std::abs(turn_deg) * std::numbers::pi / 360;
      CHECK(r.deviation_mm == Approx(9.0 / 30 * (1 / std::cos(half) - 1)).epsilon(2e-3).margin(1e-7));
    }
}
