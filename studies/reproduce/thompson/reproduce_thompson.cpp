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
double min_transit_speed(const AerosolPlan& plan) {
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

constexpr const char* kFitted =
    "coordinates of Fig. 7 and lengths of Fig. 11, which the paper does not print";
constexpr const char* kFromFit = "reading of the fitted coordinates";

double speed_pct(const AerosolPlan& plan) { return 100 * plan.report.speed_error.value; }
double position_pct(const AerosolPlan& plan) {
  return 100 * plan.report.position_error_mm.value / kFeature_mm;
}

void pictures_of(Reproduction& to, const std::string& figure, const PrintJob& job, const AerosolPlan& plan) {
  to.picture({figure + "-path", "Path of " + figure + ", --corner paper, over the wanted segments",
              report::aerosol_path_picture(job, plan, figure)});
  to.picture({figure + "-speed-error", "Speed error of " + figure,
              report::aerosol_speed_error_picture(job, plan, figure + " speed error")});
  to.picture({figure + "-position-error",
              "Position error of " + figure + ": distance to the point that moves at 3 mm/s",
              report::aerosol_path_error_picture(job, plan, figure + " position error")});
}

}  // namespace

void reproduce_thompson_corners(Reproduction& to) {
  to.note(
      "The paper does not print the coordinates of Fig. 7 and the lengths of Fig. 11. Ours are fitted to the "
      "errors that it states (\"near 60%\", \"less than 1.1 percent\", \"does not exceed 1.5%\"), so rows of "
      "these "
      "two figures test the fit; rows over all headings hold for any coordinates. Limits as in the paper: 4 "
      "mm/s "
      "and 30 mm/s² per axis, 3 mm/s wanted.");
  const PrintJob fig7 = motion::thompson_fig7(), fig11 = motion::thompson_fig11();
  const AerosolPlan seven = planned(fig7, CornerMode::kPaper), eleven = planned(fig11, CornerMode::kPaper);
  const std::string id = "thompson.corners.";
  to.row(ReproduceRow(id + "fig7-speed", "Fig. 10(a): largest speed error", "%", speed_pct(seven))
             .prints(60.0, "p. 1562, Fig. 10(a)", "produces a large (near 60%) error in speed")
             .within(0.1)
             .fitted(kFitted));
  to.row(ReproduceRow(id + "fig7-position", "Fig. 10(b): largest position error in % of 10 mm", "%",
                      position_pct(seven))
             .prints(1.1, "p. 1563, Fig. 10(b)", "is less than 1.1 percent of the overall 10-mm feature size")
             .at_most(1.1)
             .derives(1.09, "errata", kFromFit)
             .within_derived(0.1)
             .fitted(kFitted));
  to.row(ReproduceRow(id + "fig11-speed", "Fig. 12(a): largest speed error", "%", speed_pct(eleven))
             .derives(96.8, "errata", kFromFit)
             .within_derived(0.1)
             .fitted(kFitted));
  to.row(ReproduceRow(id + "fig11-position", "Fig. 12(b): largest position error in % of 10 mm", "%",
                      position_pct(eleven))
             .prints(1.5, "p. 1563, Fig. 12(b)", "it does not exceed 1.5%")
             .at_most(1.5)
             .derives(1.49, "errata", kFromFit)
             .within_derived(0.1)
             .fitted(kFitted));
  pictures_of(to, "fig7", fig7, seven);
  pictures_of(to, "fig11", fig11, eleven);
  to.picture({"fig9-speeds", "Fig. 9: speeds, grey where the shutter is closed",
              report::aerosol_speed_picture(seven, "Fig. 9 speeds")});
  to.picture(
      {"fig9-positions", "Fig. 9: positions", report::aerosol_position_picture(seven, "Fig. 9 positions")});

  const double first = error_of_segment(fig7, seven, 0, 0), sharp = error_of_segment(fig7, seven, 2, 2);
  to.row(ReproduceRow(id + "fig7-blunt", "speed error at segments 1 and 2, and at 2 and 3", "",
                      fmt::format("{:.1f} % against {:.1f} %", 100 * first, 100 * sharp))
             .prints("significantly less", "p. 1563, Fig. 10(a)",
                     "the error is significantly less due to the large angle")
             .holds(first < 0.5 * sharp, "less than half")
             .fitted(kFitted));
  to.row(ReproduceRow(id + "fig9-transit-speed", "largest speed of an axis in the slowest transit", "mm/s",
                      min_transit_speed(seven))
             .prints(4.0, "p. 1562, Fig. 9", "reaches the maximum velocity (4 mm/s) for each MTT")
             .within(1e-9)
             .arithmetic()
             .fitted(kFitted));
  to.row(ReproduceRow(id + "fig9-isolated", "speed error of segments 4 and 5", "%",
                      100 * error_of_segment(fig7, seven, 3, 4))
             .prints("desired velocities are achieved", "p. 1562, Fig. 9",
                     "the desired velocities are achieved for segments 4 and 5")
             .at_most(1e-7));

  const Sweep sweep = sweep_corners();
  to.row(ReproduceRow(id + "zero-angle", "least speed error at 0 degrees of 12 headings", "%",
                      100 * sweep.reversal)
             .prints(100.0, "p. 1563, VI", "a 0° angle results in a 100% error")
             .within(1e-6)
             .arithmetic());
  to.row(ReproduceRow(id + "monotone", "speed at the corner, 73 angles, 12 headings", "",
                      std::string(sweep.monotone ? "grows with the angle" : "does not grow with the angle"))
             .prints("increases as angle decreases", "p. 1563, Fig. 12(a)",
                     "The peak velocity error shown in Fig. 12(a) increases as angle decreases")
             .holds(sweep.monotone, "no step down"));
  to.beside({id + "half-angle", "largest difference of the corner's speed and v sin(angle/2)", "mm/s",
             sweep.formula_off_mm_s});
  to.beside(
      {id + "position-bound", "largest position error over v^2 / (2 alpha)", "", sweep.position_over_bound});
}

void reproduce_thompson_misprints(Reproduction& to) {
  to.note(
      "Formulas that do not give their value as printed; ours are the corrected ones, with one test each. "
      "docs/algorithms/aerosol.md lists them all.");
  const motion::AxisLimits limits{kVmax_mm_s, kAlpha_mm_s2};
  const auto derived = [&](const char* name, const std::string& what, double as_printed, double wanted,
                           const char* how, double ours) {
    to.row(ReproduceRow(std::string("thompson.misprints.") + name,
                        fmt::format("{}; as printed {:.3f} s", what, as_printed), "s", ours, 4)
               .derives(wanted, "errata", how)
               .within_derived(1e-9)
               .arithmetic());
  };
  derived("eq37", "(37): time of a move from 0 to -10 mm", 10.0 / 4 - 4.0 / 30, 10.0 / 4 + 4.0 / 30,
          "(37) without the sign of q1 - q0 before v_max / alpha",
          motion::mtt({0, -10, 0, 0}, 0, limits).t1_s);
  const double root_3 = std::sqrt(3.0), root_15 = std::sqrt(15.0);
  derived("fig5", "Fig. 5: least time for v0 = v1 = -3 mm/s over -0.2 mm", 2 * (root_3 + 3) / 30,
          2 * (root_15 - 3) / 30, "(23)-(26), the least of all valid candidates instead of the first",
          motion::mtt({0, -0.2, -3, -3}, 0, limits).t1_s);
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
  to.row(ReproduceRow("thompson.misprints.hairpin-speed",
                      "shortest segment between hairpins that needs no more than 4 mm/s", "mm",
                      shortest([&](double l) { return plan(l, kVmax_mm_s); }))
             .derives(1.6, "errata", "(11)-(16) at v = 3 mm/s, alpha = 30 mm/s2, v_max = 4 mm/s")
             .within_derived(1e-6)
             .arithmetic());
  to.row(ReproduceRow("thompson.misprints.hairpin-none", "shortest with any solution", "mm",
                      shortest([&](double l) { return plan(l, 1e6); }))
             .derives(1.2, "errata", "4 v^2 / alpha at v = 3 mm/s, alpha = 30 mm/s2")
             .within_derived(1e-6)
             .arithmetic());
}

void reproduce_thompson_corner_modes(Reproduction& to) {
  to.note(
      "Beside the paper, whose conclusion asks for an improved algorithm that keeps the wanted speed. Loop: "
      "the shutter "
      "closes and the stage makes the "
      "fastest loop back to the corner. Hybrid: corners that a path at constant speed can round within the "
      "tolerance (0.05 mm) keep the shutter open.");
  for (const auto& [figure, job] :
       {std::pair("fig7", motion::thompson_fig7()), std::pair("fig11", motion::thompson_fig11())}) {
    for (const CornerMode mode : {CornerMode::kPaper, CornerMode::kLoop, CornerMode::kHybrid}) {
      const AerosolPlan plan = planned(job, mode);
      const motion::AerosolReport& r = plan.report;
      const std::string who = fmt::format("thompson.corner-modes.{}-{}", figure, name(mode));
      const std::string what = fmt::format("{} {}: ", figure, name(mode));
      to.beside({who + "-time", what + "whole, shutter closed (wasted flow)", "",
                 fmt::format("{:.3f} s, {:.3f} s ({:.1f} %), {} loops, {} rounded", r.total_s, r.transit_s,
                             100 * r.transit_s / r.total_s, r.loops, r.rounded)});
      if (mode == CornerMode::kPaper) continue;
      to.beside({who + "-speed", what + "speed error, shutter open", "%", 100 * r.speed_error.value});
      to.beside({who + "-position", what + "distance from the wanted path, shutter open", "um",
                 1e3 * r.path_error_mm.value});
      to.beside({who + "-corner", what + "longest loop (4 v / alpha = 0.4 s)", "s", r.corner_s.value});
      to.picture({fmt::format("{}-{}-path", figure, name(mode)),
                  fmt::format("{} with --corner {}", figure, name(mode)),
                  report::aerosol_path_picture(job, plan, fmt::format("{} {}", figure, name(mode)))});
    }
  }
  to.picture({"fig7-loop-speeds", "fig7 with --corner loop: speeds",
              report::aerosol_speed_picture(planned(motion::thompson_fig7(), CornerMode::kLoop),
                                            "speeds with loops")});
}

}  // namespace firn
