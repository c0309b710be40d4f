// Computes Figs. 7 to 12 of Thompson and Yoon (2014), their misprints, and the two ways out of the corners.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/motion/aerosol/paper_jobs.h"
#include "core/motion/aerosol/plan.h"
#include "core/motion/aerosol/rounding.h"
#include "report/paths/aerosol_pictures.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

using motion::AerosolMachine;
using motion::AerosolPlan;
using motion::CornerMode;
using motion::Piece;
using motion::PieceKind;

constexpr double kFeature_mm = 10.0;  // position errors are in percent of this size
constexpr double kSpeed_mm_s = 3.0, kAlpha_mm_s2 = 30.0, kVmax_mm_s = 4.0;

AerosolPlan planned(const PrintJob& job, CornerMode mode) {
  return motion::plan_aerosol(job, AerosolMachine{}, {mode});
}

// Two segments of 5 mm that meet at an inner angle, the first one along `heading`.
PrintJob corner(double angle_deg, double heading_deg) {
  const double a = heading_deg * std::numbers::pi / 180,
               b = a + std::numbers::pi - angle_deg * std::numbers::pi / 180;
  const Point2 from{-5 * std::cos(a), -5 * std::sin(a)}, to{5 * std::cos(b), 5 * std::sin(b)};
  return {from, to, {{from, {0, 0}, kSpeed_mm_s}, {{0, 0}, to, kSpeed_mm_s}}};
}

// Speed with which the second segment begins.
double corner_speed(const AerosolPlan& plan) {
  for (const Piece& p : plan.pieces)
    if (p.kind == PieceKind::kPrint && p.segment == 1) return std::hypot(p.v_mm_s.x_mm, p.v_mm_s.y_mm);
  return NAN;
}

double error_of_segment(const PrintJob& job, const AerosolPlan& plan, std::int32_t from, std::int32_t to) {
  double worst = 0;
  for (const Piece& p : plan.pieces)
    if (p.kind == PieceKind::kPrint && (p.segment == from || p.segment == to))
      for (int n = 0; n <= 200; ++n) {
        const Point2 v = motion::state_at(plan, p.t_s + p.duration_s * n / 200).v_mm_s;
        worst = std::max(
            worst,
            std::abs(std::hypot(v.x_mm, v.y_mm) / job.segments[std::size_t(p.segment)].speed_mm_s - 1));
      }
  return worst;
}

// Maximum speed of an axis in the slowest of the transits.
double least_transit_speed(const AerosolPlan& plan) {
  double least = kVmax_mm_s, now = kVmax_mm_s;
  std::int32_t leading_to = -1;
  for (const Piece& p : plan.pieces) {
    if (p.kind != PieceKind::kTransit) continue;
    if (p.segment != leading_to) {
      least = std::min(least, now);
      now = 0.0;
      leading_to = p.segment;
    }
    now = std::max({now, std::abs(p.v_mm_s.x_mm), std::abs(p.v_mm_s.y_mm)});
  }
  return std::min(least, now);
}

// Inner angles against errors, over all headings.
struct Sweep {
  double formula_off_mm_s = 0, position_over_bound = 0, straight_on = 0, reversal = 1;
  bool monotone = true;
};
Sweep sweep_corners() {
  Sweep s;
  for (double heading = 0; heading < 90; heading += 7.5) {
    double before = -1;
    for (double angle = 0; angle <= 180; angle += 2.5) {
      const AerosolPlan plan = planned(corner(angle, heading), CornerMode::kPaper);
      const double v = corner_speed(plan), wanted = kSpeed_mm_s * std::sin(angle * std::numbers::pi / 360);
      s.formula_off_mm_s = std::max(s.formula_off_mm_s, std::abs(v - wanted));
      s.monotone = s.monotone && v > before - 1e-9;
      before = v;
      s.position_over_bound = std::max(s.position_over_bound, plan.report.position_error_mm.value * 2 *
                                                                  kAlpha_mm_s2 / (kSpeed_mm_s * kSpeed_mm_s));
      if (angle == 0) s.reversal = std::min(s.reversal, plan.report.speed_error.value);
      if (angle == 180) s.straight_on = std::max(s.straight_on, plan.report.speed_error.value);
    }
  }
  return s;
}

void errors_of(Reproduction& to, const std::string& figure, const PrintJob& job, const AerosolPlan& plan,
               double speed_pct, double position_pct, const char* speed_words, const char* position_words) {
  const std::string id = "thompson.corners." + figure;
  ReproduceRow speed = row_near(id + "-speed", fmt::format("largest speed error ({})", speed_words), "%",
                                speed_pct, 100 * plan.report.speed_error.value, 0.1, RowKind::kFit);
  ReproduceRow position = row_near(
      id + "-position", fmt::format("largest position error in % of 10 mm ({})", position_words), "%",
      position_pct, 100 * plan.report.position_error_mm.value / kFeature_mm, 0.1, RowKind::kFit);
  to.row(std::move(speed));
  to.row(std::move(position));
  to.picture({figure + "-path", "Path of " + figure + ", --corner paper, over the wanted segments",
              aerosol_path_picture(job, plan, figure)});
  to.picture({figure + "-speed-error", "Speed error of " + figure,
              aerosol_speed_error_picture(job, plan, figure + " speed error")});
  to.picture({figure + "-position-error",
              "Position error of " + figure + ": distance to the point that moves at 3 mm/s",
              aerosol_path_error_picture(job, plan, figure + " position error")});
}

}  // namespace

void reproduce_thompson_corners(Reproduction& to) {
  to.note(
      "The paper does not print the coordinates of Fig. 7 and the lengths of Fig. 11. Ours are fitted to the "
      "errors that it tells "
      "(\"near 60 %\", \"less than 1.1 percent\", \"does not exceed 1.5 %\"), so these four rows test the "
      "fit; the rows after them "
      "hold for any coordinates. Limits as in the paper: 4 mm/s and 30 mm/s² per axis, 3 mm/s wanted.");
  const PrintJob fig7 = motion::thompson_fig7(), fig11 = motion::thompson_fig11();
  const AerosolPlan seven = planned(fig7, CornerMode::kPaper), eleven = planned(fig11, CornerMode::kPaper);
  errors_of(to, "fig7", fig7, seven, 60.0, 1.09, "Fig. 10a: near 60 %", "Fig. 10b: less than 1.1 %");
  errors_of(to, "fig11", fig11, eleven, 96.8, 1.49, "Fig. 12a: rises as the angle falls",
            "Fig. 12b: at most 1.5 %");
  to.picture({"fig9-speeds", "Fig. 9: speeds, grey where the shutter is closed",
              aerosol_speed_picture(seven, "Fig. 9 speeds")});
  to.picture({"fig9-positions", "Fig. 9: positions", aerosol_position_picture(seven, "Fig. 9 positions")});

  const double first = error_of_segment(fig7, seven, 0, 0), sharp = error_of_segment(fig7, seven, 2, 2);
  to.row(row_holds("thompson.corners.fig7-blunt",
                   "the error at segments 1 and 2 is significantly less than at 2 and 3", "less",
                   fmt::format("{:.1f} % against {:.1f} %", 100 * first, 100 * sharp), first < 0.5 * sharp,
                   RowKind::kComputed));
  to.row(row_near("thompson.corners.fig9-transit-speed",
                  "in every transit one axis reaches the largest speed", "mm/s", 4.0,
                  least_transit_speed(seven), 1e-9, RowKind::kFit));
  to.row(row_holds("thompson.corners.fig9-isolated", "segments 4 and 5 keep the wanted speed", "no error",
                   fmt::format("{:.1e} %", 100 * error_of_segment(fig7, seven, 3, 4)),
                   error_of_segment(fig7, seven, 3, 4) < 1e-9));

  const Sweep sweep = sweep_corners();
  to.row(row_near("thompson.corners.zero-angle", "speed error at 0 degrees, any heading", "%", 100.0,
                  100 * sweep.reversal, 1e-6, RowKind::kProperty));
  to.row(row_holds("thompson.corners.monotone", "speed at the corner grows with the angle, any heading",
                   "error increases as angle decreases",
                   sweep.monotone ? "monotone over 12 headings, 73 angles" : "not monotone", sweep.monotone));
  to.row(row_at_most("thompson.corners.half-angle", "speed at the corner less v sin(angle/2), (52), (53)",
                     "mm/s", std::string(), sweep.formula_off_mm_s, 1e-9, RowKind::kProperty));
  to.row(row_at_most("thompson.corners.position-bound", "position error over v^2 / (2 alpha)", "",
                     std::string(), sweep.position_over_bound, 1.0 + 1e-9, RowKind::kProperty));
}

void reproduce_thompson_misprints(Reproduction& to) {
  to.note(
      "Formulas that do not give what they are for as printed; ours are the corrected ones, with one test "
      "each. docs/algorithms/aerosol.md lists them all.");
  const motion::AxisLimits limits{kVmax_mm_s, kAlpha_mm_s2};
  const auto shown = [&](const char* name, const char* what, double printed, double wanted, double ours) {
    ReproduceRow row =
        row_near(std::string("thompson.misprints.") + name,
                 fmt::format("{}; as printed {:.3f} s", what, printed), "s", wanted, ours, 1e-9);
    row.decimals = 4;
    to.row(std::move(row));
  };
  shown("eq37", "(37): time of a move from 0 to -10 mm", 10.0 / 4 - 4.0 / 30, 10.0 / 4 + 4.0 / 30,
        motion::mtt({0, -10, 0, 0}, 0, limits).t1_s);
  const double root_3 = std::sqrt(3.0), root_15 = std::sqrt(15.0);
  shown("fig5", "Fig. 5: least time for v0 = v1 = -3 mm/s over -0.2 mm", 2 * (root_3 + 3) / 30,
        2 * (root_15 - 3) / 30, motion::mtt({0, -0.2, -3, -3}, 0, limits).t1_s);
  const auto hairpin = [](double length) {
    const Point2 a{0, 0}, b{5, 0}, c{5 - length, 0}, d{10, 0};
    return PrintJob{a, d, {{a, b, kSpeed_mm_s}, {b, c, kSpeed_mm_s}, {c, d, kSpeed_mm_s}}};
  };
  const auto shortest = [&](auto possible) {  // bisection over the length between two hairpins
    double low = 0.1, high = 5.0;
    for (int n = 0; n < 60; ++n) (possible(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
    return high;
  };
  const auto plan = [&](double length, double v_max) {
    AerosolMachine machine;
    machine.axis.v_max_mm_s = v_max;
    return motion::plan_aerosol(hairpin(length), machine, {CornerMode::kPaper}).ok();
  };
  to.row(row_near("thompson.misprints.hairpin-speed",
                  "shortest segment between hairpins that needs no more than 4 mm/s; not in the paper", "mm",
                  1.6, shortest([&](double l) { return plan(l, kVmax_mm_s); }), 1e-6));
  to.row(row_near("thompson.misprints.hairpin-none",
                  "shortest with any solution, 4 v^2 / alpha; not in the paper", "mm", 1.2,
                  shortest([&](double l) { return plan(l, 1e6); }), 1e-6));
}

void reproduce_thompson_corner_modes(Reproduction& to) {
  to.note(
      "The paper's conclusion asks for an improved algorithm that keeps the wanted speed. Loop: the shutter "
      "closes and the stage makes the "
      "fastest loop back to the corner. Hybrid: corners that a path at constant speed can round within the "
      "tolerance (0.05 mm) keep the shutter open.");
  for (const auto& [figure, job] :
       {std::pair("fig7", motion::thompson_fig7()), std::pair("fig11", motion::thompson_fig11())}) {
    for (const CornerMode mode : {CornerMode::kPaper, CornerMode::kLoop, CornerMode::kHybrid}) {
      const AerosolPlan plan = planned(job, mode);
      const motion::AerosolReport& r = plan.report;
      const std::string who = fmt::format("thompson.corner-modes.{}-{}", figure, name(mode));
      to.row(row_informative(who + "-time",
                             fmt::format("{} {}: whole, shutter closed (wasted flow)", figure, name(mode)),
                             "", std::string(),
                             fmt::format("{:.3f} s, {:.3f} s ({:.1f} %), {} loops, {} rounded", r.total_s,
                                         r.transit_s, 100 * r.transit_s / r.total_s, r.loops, r.rounded),
                             RowKind::kComputed));
      if (mode == CornerMode::kPaper) continue;
      to.row(row_at_most(who + "-speed", fmt::format("{} {}: speed error, shutter open", figure, name(mode)),
                         "%", std::string(), 100 * r.speed_error.value, 0.1, RowKind::kProperty));
      const double tolerance_um = mode == CornerMode::kLoop ? 1.0 : 50.0;
      to.row(
          row_at_most(who + "-position",
                      fmt::format("{} {}: distance from the wanted path, shutter open", figure, name(mode)),
                      "um", std::string(), 1e3 * r.path_error_mm.value, tolerance_um, RowKind::kProperty));
      to.row(row_at_most(
          who + "-corner", fmt::format("{} {}: longest loop against 4 v / alpha", figure, name(mode)), "s",
          std::string(), r.corner_s.value, 4 * kSpeed_mm_s / kAlpha_mm_s2 + 1e-12, RowKind::kProperty));
      to.picture({fmt::format("{}-{}-path", figure, name(mode)),
                  fmt::format("{} with --corner {}", figure, name(mode)),
                  aerosol_path_picture(job, plan, fmt::format("{} {}", figure, name(mode)))});
    }
  }
  to.picture(
      {"fig7-loop-speeds", "fig7 with --corner loop: speeds",
       aerosol_speed_picture(planned(motion::thompson_fig7(), CornerMode::kLoop), "speeds with loops")});
}

}  // namespace firn
