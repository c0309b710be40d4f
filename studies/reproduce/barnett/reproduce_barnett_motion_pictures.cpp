#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"
#include "report/draw/charts.h"
#include "report/paths/plan_plot.h"
#include "studies/reproduce/barnett/reproduce_barnett_motion.h"

namespace firn::barnett {
namespace {

using namespace motion;
using report::ChartOptions;
using report::Series;

Series series(std::string label, std::vector<double> x, std::vector<double> y, int style) {
  Series s;
  s.label = std::move(label);
  x.resize(y.size());
  s.x = std::move(x);
  s.y = std::move(y);
  s.style = style;
  return s;
}

Series limit_line(const std::string& label, double value, double until) {
  return series(label, {0, until}, {value, value}, Series::kReference);
}

Series both_limits(double value, double until) {
  return series("limit", {0, until, until, 0, until}, {value, value, NAN, -value, -value},
                Series::kReference);
}

ChartOptions axes(std::string title, std::string x, std::string y) {
  ChartOptions o;
  o.title = std::move(title);
  o.x_name = std::move(x);
  o.y_name = std::move(y);
  return o;
}

/// Speed over position, each interval at its middle.
Series speed_over_s(const thesis::Profile& p, const std::string& label, int style) {
  std::vector<double> s, c;
  for (std::size_t k = 0; k < p.dt_s.size(); ++k) {
    s.push_back(0.5 * (p.s_mm[k] + p.s_mm[k + 1]));
    c.push_back((p.s_mm[k + 1] - p.s_mm[k]) / p.dt_s[k]);
  }
  return series(label, s, c, style);
}

void figure_4_4(Reproduction& to, const Chapter4& c) {
  const ThesisSteps& steps = c.well.steps[0];
  to.picture({"fig-4-4",
              "Fig. 4-4: total speed after VCON, ACON and at the end, over the path to the 90 degree corner "
              "(well placed)",
              report::line_chart({speed_over_s(steps.vcon, "VCON", 2), speed_over_s(steps.acon, "ACON", 1),
                                  speed_over_s(steps.final, "JCON, AREST, JCON at the tick", 0)},
                                 axes("", "path position [mm]", "speed [mm/s]"))});
}

void figure_4_7(Reproduction& to, const Sampled& s) {
  const double end = s.duration_s();
  std::vector<double> x, y;
  for (const Point2& p : s.at) {
    x.push_back(p.x_mm - thesis::kWellPlaced.x_mm);
    y.push_back(p.y_mm - thesis::kWellPlaced.y_mm);
  }
  to.picture({"fig-4-7-position", "Fig. 4-7: position, well-placed path",
              report::line_chart({series("x", s.t_s, x, 0), series("y", s.t_s, y, 1)},
                                 axes("", "time [s]", "position [mm]"))});
  to.picture({"fig-4-7-speed", "Fig. 4-7: speed",
              report::line_chart({series("speed", s.t_s, s.speed, 0), limit_line("limit", 125, end)},
                                 axes("", "time [s]", "speed [mm/s]"))});
  to.picture(
      {"fig-4-7-acceleration", "Fig. 4-7: total acceleration",
       report::line_chart({series("acceleration", s.t_s, s.acceleration, 0), limit_line("limit", 500, end)},
                          axes("", "time [s]", "acceleration [mm/s2]"))});
  to.picture({"fig-4-7-jerk", "Fig. 4-7: total jerk, which the method does not hold",
              report::line_chart({series("jerk", s.t_s, s.jerk, 0), limit_line("limit", 4000, end)},
                                 axes("", "time [s]", "jerk [mm/s3]"))});
}

void figure_4_8(Reproduction& to, const Sampled& s) {
  const Sampled::Joint &a = s.joints[0], &b = s.joints[1];
  const auto chart = [&](const char* name, const char* caption, const std::vector<double>& one,
                         const std::vector<double>& two, const char* unit) {
    to.picture({name, caption,
                report::line_chart({series("theta 1", s.t_s, one, 0), series("theta 2", s.t_s, two, 1)},
                                   axes("", "time [s]", unit))});
  };
  std::vector<double> one, two;  // offset to fit on one plot, as the thesis does
  for (std::size_t i = 0; i < s.t_s.size(); ++i) {
    one.push_back(a.angle[i] - a.angle[0]);
    two.push_back(b.angle[i] - b.angle[0]);
  }
  chart("fig-4-8-position", "Fig. 4-8: joint angles from their start, well-placed path", one, two,
        "angle [deg]");
  chart("fig-4-8-rate", "Fig. 4-8: joint rates (limits 33 and 39 deg/s)", a.rate, b.rate, "rate [deg/s]");
  chart("fig-4-8-acceleration", "Fig. 4-8: joint accelerations (limits 165 and 195 deg/s2)", a.acceleration,
        b.acceleration, "acceleration [deg/s2]");
  chart("fig-4-8-jerk", "Fig. 4-8: joint jerks (limits 1320 and 1560 deg/s3)", a.jerk, b.jerk,
        "jerk [deg/s3]");
}

void figure_4_9(Reproduction& to, const Chapter4& c) {
  const auto over_s = [](const Sampled& s, const std::vector<double>& y, const char* label, int style) {
    return series(label, s.s_mm, y, style);
  };
  to.picture({"fig-4-9-speed", "Fig. 4-9: speed over position at both places",
              report::line_chart({over_s(c.well_seen, c.well_seen.speed, "well placed", 0),
                                  over_s(c.poor_seen, c.poor_seen.speed, "poorly placed", 1)},
                                 axes("", "path position [mm]", "speed [mm/s]"))});
  to.picture({"fig-4-9-rate", "Fig. 4-9: rate of theta 2 over position, with its limit",
              report::line_chart(
                  {over_s(c.well_seen, c.well_seen.joints[1].rate, "well placed", 0),
                   over_s(c.poor_seen, c.poor_seen.joints[1].rate, "poorly placed", 1), both_limits(39, 353)},
                  axes("", "path position [mm]", "rate [deg/s]"))});
}

void figure_4_12(Reproduction& to, const Chapter4& c) {
  const Sampled &m = c.well_seen, &d = c.fallback_seen;
  const auto chart = [&](const char* name, const char* caption, const std::vector<double>& ours,
                         const std::vector<double>& theirs, const char* unit) {
    to.picture({name, caption,
                report::line_chart({series("MTTS", m.t_s, ours, 0), series("default", d.t_s, theirs, 1)},
                                   axes("", "time [s]", unit))});
  };
  chart("fig-4-12-speed", "Fig. 4-12: speed, MTTS and the default technique", m.speed, d.speed,
        "speed [mm/s]");
  chart("fig-4-12-acceleration", "Fig. 4-12: total acceleration", m.acceleration, d.acceleration,
        "acceleration [mm/s2]");
  chart("fig-4-12-jerk", "Fig. 4-12: total jerk", m.jerk, d.jerk, "jerk [mm/s3]");
}

void figure_4_13(Reproduction& to, const Chapter4& c) {
  constexpr double kWide = 18, kHigh = 12;  // the chart's shape, so that both axes have one scale
  const auto line = [](const Sampled& s, const char* label, int style) {
    std::vector<double> x, y;  // a window at the corner, which the motion crosses once
    for (const Point2& p : s.at) {
      const double px = p.x_mm - thesis::kWellPlaced.x_mm, py = p.y_mm - thesis::kWellPlaced.y_mm;
      if (px < kWide && py < kHigh) {
        x.push_back(px);
        y.push_back(py);
      }
    }
    return series(label, x, y, style);
  };
  to.picture({"fig-4-13", "Fig. 4-13: the motion at the 90 degree corner",
              report::line_chart({line(c.well_seen, "MTTS", 0), line(c.fallback_seen, "default", 1)},
                                 axes("", "x [mm]", "y [mm]"))});
}

/// A 4 Hz low pass (second order, run forwards and backwards so that nothing is delayed), as for Fig. 4-14.
std::vector<double> low_pass(std::vector<double> values, double tick_s) {
  const double keep = std::exp(-2 * std::numbers::pi * 4.0 * tick_s);
  for (int pass = 0; pass < 2; ++pass) {
    double state = 0;
    for (double& v : values) {
      state = keep * state + (1 - keep) * v;
      v = state;
    }
    std::reverse(values.begin(), values.end());
  }
  return values;
}

void figure_4_14(Reproduction& to, const Chapter4& c) {
  const auto along = [](const Sampled& s, bool y) {
    std::vector<double> a;
    for (std::size_t i = 0; i + 2 < s.at.size(); ++i) {
      const auto at = [&](std::size_t k) { return y ? s.at[k].y_mm : s.at[k].x_mm; };
      a.push_back((at(i + 2) - 2 * at(i + 1) + at(i)) / (0.016 * 0.016));
    }
    return low_pass(a, 0.016);
  };
  for (const bool y : {false, true})
    to.picture(
        {y ? "fig-4-14-y" : "fig-4-14-x",
         fmt::format("Fig. 4-14: acceleration along {} behind a 4 Hz low pass (commanded, not measured)",
                     y ? "y" : "x"),
         report::line_chart({series("MTTS", c.well_seen.t_s, along(c.well_seen, y), 0),
                             series("default", c.fallback_seen.t_s, along(c.fallback_seen, y), 1)},
                            axes("", "time [s]", "acceleration [mm/s2]"))});
}

using Trace = std::vector<TraceSample>;

Trace traced(const std::vector<Point2>& points, const Arm& arm, Method method, PathKind kind) {
  PathInput in{.points = points};
  in.origin = thesis::kWellPlaced;
  in.kind = kind;
  PlanOptions options;
  options.method = method;
  options.trace_step_s = options.tick_s;
  options.lower_bound = false;
  return plan(in, arm, cobra600_limits(), options).trace;
}

void append(Trace& all, const Trace& more) { all.insert(all.end(), more.begin(), more.end()); }

void figures_4_11_and_16(Reproduction& to, const Chapter4& c) {
  to.picture(
      {"fig-4-11", "As Fig. 4-11: the speed of MTTS along the path of Fig. 4-2, well placed",
       report::speed_map(traced(c.points, *c.arm, Method::kThesis, PathKind::kBoundary), 125, "MTTS")});
  const BoxLayer layer = box_layer();
  Trace constant, variable;
  for (const auto& p : layer.boundaries) {
    append(constant, traced(p, *c.arm, Method::kConstant, PathKind::kBoundary));
    append(variable, traced(p, *c.arm, Method::kThesis, PathKind::kBoundary));
  }
  for (const auto& p : layer.lines) append(constant, traced(p, *c.arm, Method::kConstant, PathKind::kFill));
  for (const auto& p : layer.contours) append(variable, traced(p, *c.arm, Method::kThesis, PathKind::kFill));
  to.picture({"fig-4-16-constant",
              "Fig. 4-16 (a): a layer of the box's walls at constant speed, straight fill",
              report::speed_map(constant, 125, "constant speed")});
  to.picture({"fig-4-16-variable", "Fig. 4-16 (b): the same walls with MTTS, concentric fill",
              report::speed_map(variable, 125, "MTTS")});
}

}  // namespace

void pictures(Reproduction& to, const Chapter4& planned) {
  figure_4_4(to, planned);
  figure_4_7(to, planned.well_seen);
  figure_4_8(to, planned.well_seen);
  figure_4_9(to, planned);
  figures_4_11_and_16(to, planned);
  figure_4_12(to, planned);
  figure_4_13(to, planned);
  figure_4_14(to, planned);
}

}  // namespace firn::barnett
