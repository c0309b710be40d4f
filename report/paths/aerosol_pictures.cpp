#include "report/paths/aerosol_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/aerosol/measure.h"
#include "core/path/line_stations.h"
#include "report/draw/charts.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_page.h"

namespace firn::report {
namespace {

using motion::AerosolPlan;
using motion::Piece;
using motion::PieceKind;
using motion::PlaneState;
using report::Series;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kSamples = 1500, kMinPerPiece = 4;

bool is_open(const Piece& p) { return p.kind == PieceKind::kPrint || p.kind == PieceKind::kRound; }

// f at the ends of every piece and evenly between; `open_only` breaks the line where the shutter is closed.
template <class Function>
Series sampled(const AerosolPlan& plan, const std::string& label, int style, bool open_only, Function f) {
  Series s{label, {}, {}, style};
  const double step = std::max(1e-9, plan.duration_s() / kSamples);
  for (const Piece& p : plan.pieces) {
    const int count = std::max(kMinPerPiece, int(std::ceil(p.duration_s / step)));
    for (int n = 0; n <= count; ++n) {
      const double dt = p.duration_s * n / count;
      s.x.push_back(p.t_s + dt);
      s.y.push_back(open_only && !is_open(p) ? kNone : f(p, dt));
    }
  }
  return s;
}

report::ChartOptions time_chart(const AerosolPlan& plan, const std::string& title,
                                const std::string& y_name) {
  report::ChartOptions o;
  o.title = title;
  o.x_name = "time [s]";
  o.y_name = y_name;
  o.shaded_label = "shutter closed";
  double closed = 0.0;
  for (const ShutterSpan& span : plan.open) {
    if (span.open_s > closed) o.shaded.push_back({closed, span.open_s});
    closed = span.close_s;
  }
  if (plan.duration_s() > closed) o.shaded.push_back({closed, plan.duration_s()});
  return o;
}

double speed(const PlaneState& s) { return std::hypot(s.v_mm_s.x_mm, s.v_mm_s.y_mm); }

// Blue where the speed is as wanted, towards orange where it falls or rises by half.
std::string color_of(double error) {
  const double share = std::clamp(std::abs(error) / 0.5, 0.0, 1.0);
  const auto mix = [&](double a, double b) { return int(std::lround(a + share * (b - a))); };
  char text[40];
  std::snprintf(text, sizeof text, "rgb(%d,%d,%d)", mix(0, 230), mix(114, 120), mix(178, 0));
  return text;
}

std::string line(const char* style, double x0, double y0, double x1, double y1) {
  char text[240];
  std::snprintf(text, sizeof text, "<path fill=\"none\" %s d=\"M%.2f %.2fL%.2f %.2f\"/>\n", style, x0, y0, x1,
                y1);
  return text;
}

std::string aerosol_legend(double left, double top) {
  std::string s;
  const auto entry = [&](int n, const std::string& sample, const char* text) {
    const double x = left + 190.0 * (n % 2), y = top + 20.0 * (n / 2);
    s += "<g transform=\"translate(" + std::to_string(x) + " " + std::to_string(y) + ")\">" + sample +
         report::svg_text(32, 4, "start", "tick", text) + "</g>\n";
  };
  entry(0, line(("stroke-width=\"3\" stroke=\"" + color_of(0) + "\"").c_str(), 0, 0, 26, 0),
        "at the wanted speed");
  entry(1, line(("stroke-width=\"3\" stroke=\"" + color_of(1) + "\"").c_str(), 0, 0, 26, 0), "off by 50 %");
  entry(2, line("stroke=\"var(--soft)\" stroke-width=\"1.4\" stroke-dasharray=\"4 3\"", 0, 0, 26, 0),
        "shutter closed");
  return s;
}

}  // namespace

std::string aerosol_path_picture(const PrintJob& job, const AerosolPlan& plan, const std::string& title) {
  double low_x = job.start.x_mm, high_x = low_x, low_y = job.start.y_mm, high_y = low_y;
  const auto take = [&](const Point2& p) {
    low_x = std::min(low_x, p.x_mm);
    high_x = std::max(high_x, p.x_mm);
    low_y = std::min(low_y, p.y_mm);
    high_y = std::max(high_y, p.y_mm);
  };
  take(job.end);
  for (const Piece& p : plan.pieces) {
    take(p.p_mm);
    take(motion::state_of(p, 0.5 * p.duration_s).p_mm);
  }
  // One scale for both axes.
  constexpr double kWidth = 460, kMargin = 0.06;
  const double width_mm = std::max(1e-6, high_x - low_x) * (1 + 2 * kMargin),
               height_mm = std::max(1e-6, high_y - low_y) * (1 + 2 * kMargin);
  const double px_per_mm = std::min(390.0 / width_mm, 460.0 / height_mm);
  report::Frame f;
  f.right = f.left + px_per_mm * width_mm;
  f.bottom = f.top + px_per_mm * height_mm;
  const double dx = kMargin * (high_x - low_x), dy = kMargin * (high_y - low_y);
  const report::Axis x(low_x - dx, high_x + dx, f.left, f.right, 6),
      y(low_y - dy, high_y + dy, f.bottom, f.top, 6);
  std::string s =
      report::svg_open(kWidth, f.bottom + 90, title) + report::draw_axes(f, x, y, "x [mm]", "y [mm]");
  for (const PrintSegment& segment : job.segments)
    s += line("stroke=\"var(--line)\" stroke-width=\"7\" stroke-linecap=\"round\"", x.px(segment.from.x_mm),
              y.px(segment.from.y_mm), x.px(segment.to.x_mm), y.px(segment.to.y_mm));
  for (const bool open : {false, true})
    for (const Piece& p : plan.pieces) {
      if (is_open(p) != open) continue;
      const int count = p.a_mm_s2 == Point2{} ? 1 : 10;
      for (int n = 0; n < count; ++n) {
        const PlaneState a = motion::state_of(p, p.duration_s * n / count),
                         b = motion::state_of(p, p.duration_s * (n + 1) / count);
        const std::string style =
            open ? "stroke-width=\"2.6\" stroke-linecap=\"round\" stroke=\"" +
                       color_of(speed(motion::state_of(p, p.duration_s * (n + 0.5) / count)) /
                                    job.segments[std::size_t(p.segment)].speed_mm_s -
                                1.0) +
                       "\""
                 : std::string("stroke=\"var(--soft)\" stroke-width=\"1.4\" stroke-dasharray=\"") +
                       (count == 1 ? "4 3" : "none") + "\"";
        s += line(style.c_str(), x.px(a.p_mm.x_mm), y.px(a.p_mm.y_mm), x.px(b.p_mm.x_mm), y.px(b.p_mm.y_mm));
      }
    }
  const auto point = [&](const Point2& p, const char* text) {
    char mark[120];
    std::snprintf(mark, sizeof mark, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.4\" fill=\"var(--fg)\"/>",
                  x.px(p.x_mm), y.px(p.y_mm));
    s += mark + report::svg_text(x.px(p.x_mm) + 7, y.px(p.y_mm) - 6, "start", "tick", text);
  };
  point(job.start, "start");
  if (!(job.end == job.start)) point(job.end, "end");
  return s + aerosol_legend(16, f.bottom + 56) + "</svg>\n";
}

std::string aerosol_speed_picture(const AerosolPlan& plan, const std::string& title) {
  return report::line_chart(
      {sampled(plan, "x", 0, false,
               [](const Piece& p, double dt) { return motion::state_of(p, dt).v_mm_s.x_mm; }),
       sampled(plan, "y", 1, false,
               [](const Piece& p, double dt) { return motion::state_of(p, dt).v_mm_s.y_mm; }),
       sampled(plan, "nozzle", Series::kReference, false,
               [](const Piece& p, double dt) { return speed(motion::state_of(p, dt)); })},
      time_chart(plan, title, "speed [mm/s]"));
}

std::string aerosol_position_picture(const AerosolPlan& plan, const std::string& title) {
  return report::line_chart(
      {sampled(plan, "x", 0, false,
               [](const Piece& p, double dt) { return motion::state_of(p, dt).p_mm.x_mm; }),
       sampled(plan, "y", 1, false,
               [](const Piece& p, double dt) { return motion::state_of(p, dt).p_mm.y_mm; })},
      time_chart(plan, title, "position [mm]"));
}

std::string aerosol_speed_error_picture(const PrintJob& job, const AerosolPlan& plan,
                                        const std::string& title) {
  report::ChartOptions o = time_chart(plan, title, "speed error [%]");
  o.y_range = {0.0, std::max(1.0, 110 * plan.report.speed_error.value)};
  const auto error = [&](const Piece& p, double dt) {
    return 100 *
           std::abs(speed(motion::state_of(p, dt)) / job.segments[std::size_t(p.segment)].speed_mm_s - 1.0);
  };
  return report::line_chart({sampled(plan, "speed error", 0, true, error)}, o);
}

std::string aerosol_path_error_picture(const PrintJob& job, const AerosolPlan& plan,
                                       const std::string& title) {
  report::ChartOptions o = time_chart(plan, title, "position error [µm]");
  std::int32_t segment = -1;
  PlaneState begin;
  double begin_s = 0.0;
  const auto moving_point = [&](const Piece& p,
                                double dt) {  // called in time: a new segment starts its point
    if (p.segment != segment) {
      segment = p.segment;
      begin = motion::state_of(p, 0.0);
      begin_s = p.t_s;
    }
    const PrintSegment& s = job.segments[std::size_t(segment)];
    const double length = std::hypot(s.to.x_mm - s.from.x_mm, s.to.y_mm - s.from.y_mm),
                 gone = s.speed_mm_s * (p.t_s + dt - begin_s) / length;
    const Point2 at = motion::state_of(p, dt).p_mm;
    if (p.kind == PieceKind::kRound) {
      segment = -1;
      return 1e3 * std::min(distance_to(at, s), distance_to(at, job.segments[std::size_t(p.segment - 1)]));
    }
    return 1e3 * std::hypot(at.x_mm - begin.p_mm.x_mm - gone * (s.to.x_mm - s.from.x_mm),
                            at.y_mm - begin.p_mm.y_mm - gone * (s.to.y_mm - s.from.y_mm));
  };
  o.y_range = {0.0, std::max(1.0, 1.1e3 * plan.report.position_error_mm.value)};
  return report::line_chart({sampled(plan, "to the point at the wanted speed", 0, true, moving_point)}, o);
}

std::string aerosol_acceleration_picture(const AerosolPlan& plan, const motion::AerosolMachine& machine,
                                         const std::string& title) {
  const double limit = machine.axis.alpha_mm_s2, end = plan.duration_s();
  return report::line_chart(
      {sampled(plan, "x", 0, false, [](const Piece& p, double) { return p.a_mm_s2.x_mm; }),
       sampled(plan, "y", 1, false, [](const Piece& p, double) { return p.a_mm_s2.y_mm; }),
       {"limit", {0, end, end, 0}, {limit, limit, -limit, -limit}, Series::kReference}},
      time_chart(plan, title, "acceleration [mm/s²]"));
}

std::string aerosol_plot(const PrintJob& job, const AerosolPlan& plan, const motion::AerosolMachine& machine,
                         const std::string& title) {
  const std::string charts[] = {aerosol_path_picture(job, plan, "path"),
                                aerosol_speed_picture(plan, "speeds"),
                                aerosol_acceleration_picture(plan, machine, "accelerations"),
                                aerosol_position_picture(plan, "positions"),
                                aerosol_speed_error_picture(job, plan, "speed error"),
                                aerosol_path_error_picture(job, plan, "position error")};
  constexpr double kCell = 480, kHeight = 400;
  constexpr std::string_view kOpen = "<svg ";
  std::string s =
      report::svg_open(3 * kCell, 2 * kHeight + 40, title) + "<style>" + report::kReportStyle +
      "svg { background: var(--bg); font-family: system-ui, \"DejaVu Sans\", sans-serif; }</style>\n" +
      report::svg_text(16, 24, "start", "name", title);
  for (int n = 0; n < 6; ++n) {
    char place[120];
    std::snprintf(place, sizeof place, "<svg x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\" ",
                  kCell * (n % 3) + 10, 40 + kHeight * (n / 3), kCell - 20, kHeight - 10);
    s += place + charts[n].substr(kOpen.size());
  }
  return s + "</svg>\n";
}

}  // namespace firn::report
