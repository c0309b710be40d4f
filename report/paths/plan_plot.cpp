#include "report/paths/plan_plot.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "report/draw/charts.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_page.h"

namespace firn {
namespace {

using motion::TraceSample;

constexpr std::size_t kPoints = 600;  // columns of a chart; each keeps its minimum and maximum
constexpr double kDegrees = 180.0 / std::numbers::pi;

replay::Series drawn(const std::vector<TraceSample>& trace,
                     const std::function<double(const TraceSample&)>& value) {
  replay::Series line;
  const std::size_t step = std::max<std::size_t>(1, trace.size() / kPoints);
  for (std::size_t n = 0; n < trace.size(); n += step) {
    std::size_t low = n, high = n;
    for (std::size_t k = n; k < std::min(n + step, trace.size()); ++k) {
      if (value(trace[k]) < value(trace[low])) low = k;
      if (value(trace[k]) > value(trace[high])) high = k;
    }
    for (std::size_t k : {std::min(low, high), std::max(low, high)})
      if (line.x.empty() || trace[k].t_s > line.x.back()) {
        line.x.push_back(trace[k].t_s);
        line.y.push_back(value(trace[k]));
      }
  }
  return line;
}

// The limit, and for values with a sign its other side, as one line with a gap.
replay::Series limit_line(double from_s, double to_s, double value, bool both_sides) {
  replay::Series line{"limit", {from_s, to_s}, {value, value}, replay::Series::kReference};
  if (!both_sides) return line;
  line.x.insert(line.x.end(), {to_s, from_s, to_s});
  line.y.insert(line.y.end(), {std::nan(""), -value, -value});
  return line;
}

std::string chart(const PlanPlot& p, const std::string& name, const std::string& unit, double limit,
                  bool signed_values, const std::function<double(const TraceSample&)>& value) {
  std::vector<replay::Series> series{drawn(p.trace, value)};
  series[0].label = name;
  if (std::isfinite(limit))
    series.push_back(limit_line(p.trace.front().t_s, p.trace.back().t_s, limit, signed_values));
  replay::ChartOptions options;
  options.title = name;
  options.x_name = "time [s]";
  options.y_name = unit;
  options.from_zero = !signed_values;  // the legend has the name
  // Motions that stay below their limit are drawn to its scale; the others show by how much they leave it.
  double reach = std::isfinite(limit) ? limit : 1e-9;
  for (double y : series[0].y) reach = std::max(reach, std::abs(y));
  options.y_range = std::pair(signed_values ? -1.08 * reach : 0.0, 1.08 * reach);
  return replay::line_chart(series, options);
}

// Cividis at five points: legible without colour vision and on paper.
std::string colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> stops{
      {{0, 34, 78}, {65, 77, 107}, {124, 123, 120}, {188, 175, 111}, {254, 232, 56}}};
  const double x = std::clamp(share, 0.0, 1.0) * 4.0;
  const std::size_t i = std::min<std::size_t>(3, std::size_t(x));
  std::array<int, 3> c{};
  for (std::size_t k = 0; k < 3; ++k)
    c[k] = int(std::lround(stops[i][k] + (stops[i + 1][k] - stops[i][k]) * (x - double(i))));
  return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
}

std::string placed(const std::string& svg, double x, double y, double width, double height) {
  return fmt::format(
             "<svg x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" overflow=\"visible\">", x, y,
             width, height) +
         svg + "</svg>\n";
}

std::string certificate_table(const Certificate& c, double left, double top) {
  std::string s;
  int n = 0;
  const auto row = [&](const std::string& name, const std::string& ratio, const std::string& at) {
    const double y = top + 24.0 * n++;
    s += replay::svg_text(left, y, "start", "name", name) +
         replay::svg_text(left + 300, y, "end", "name", ratio) +
         replay::svg_text(left + 420, y, "end", "name", at);
  };
  row("limit", "largest ratio", "at [s]");
  for (const LimitRatio& l : c.limits) row(l.limit, replay::number(l.ratio, 4), replay::number(l.time_s, 3));
  row("duration", replay::number(c.duration_s, 3) + " s", "");
  if (c.lower_bound_s > 0.0)
    row("lower bound (speed, acceleration)", replay::number(c.lower_bound_s, 3) + " s", "");
  return s;
}

}  // namespace

std::string speed_map(const std::vector<TraceSample>& trace, double top_mm_s, const std::string& title) {
  constexpr double kWidth = 424, kHeight = 380, kBarTop = 330;
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  for (const TraceSample& t : trace) {
    x0 = std::min(x0, t.at.x_mm);
    x1 = std::max(x1, t.at.x_mm);
    y0 = std::min(y0, t.at.y_mm);
    y1 = std::max(y1, t.at.y_mm);
  }
  replay::Frame f{54, 10, 414, 262};
  // One scale for both axes: a circle stays a circle.
  const double room_x = f.right - f.left - 20, room_y = f.bottom - f.top - 20;
  const double scale = std::max({(x1 - x0) / room_x, (y1 - y0) / room_y, 1e-6});
  const double half_x = 0.5 * scale * (f.right - f.left), half_y = 0.5 * scale * (f.bottom - f.top);
  const replay::Axis x(0.5 * (x0 + x1) - half_x, 0.5 * (x0 + x1) + half_x, f.left, f.right, 6);
  const replay::Axis y(0.5 * (y0 + y1) - half_y, 0.5 * (y0 + y1) + half_y, f.bottom, f.top, 6);
  std::string s = replay::svg_open(kWidth, kHeight, title) + replay::draw_axes(f, x, y, "x [mm]", "y [mm]");
  s += "<g fill=\"none\" stroke-width=\"4\" stroke-linecap=\"round\">\n";
  const std::size_t step = std::max<std::size_t>(1, trace.size() / 800);
  for (std::size_t n = 0; n + 1 < trace.size(); n += step) {
    const TraceSample &a = trace[n], &b = trace[std::min(n + step, trace.size() - 1)];
    if (b.s_mm < a.s_mm) continue;  // another path begins
    s += fmt::format("<path stroke=\"{}\" d=\"M{:.2f} {:.2f}L{:.2f} {:.2f}\"/>",
                     colour(0.5 * (a.total[0] + b.total[0]) / top_mm_s), x.px(a.at.x_mm), y.px(a.at.y_mm),
                     x.px(b.at.x_mm), y.px(b.at.y_mm));
  }
  s += "</g>\n";
  for (int n = 0; n < 60; ++n)
    s += fmt::format("<rect x=\"{:.1f}\" y=\"{:.0f}\" width=\"6.4\" height=\"12\" fill=\"{}\"/>",
                     f.left + 6.0 * n, kBarTop, colour((n + 0.5) / 60.0));
  for (int n = 0; n <= 4; ++n)
    s += replay::svg_text(f.left + 90.0 * n, kBarTop + 28, "middle", "tick",
                          replay::number(top_mm_s * n / 4.0, 0));
  s += replay::svg_text(f.left + 180, kBarTop + 46, "middle", "name", "speed [mm/s]");
  return s + "</svg>\n";
}

std::vector<TraceSample> trace_of_samples(const Trajectory& t, const std::vector<Point2>& tool) {
  const double h = t.tick_s;
  const std::size_t axes = std::min<std::size_t>(std::size_t(t.axes), motion::kMaxJoints);
  // Differences over whole ticks, each placed at its own end: a motion that has not started counts as rest.
  const auto differences = [&](const std::function<double(std::size_t)>& value, std::size_t n) {
    const auto at = [&](std::size_t back) { return value(n >= back ? n - back : 0); };
    return std::array<double, 3>{(at(0) - at(1)) / h, (at(0) - 2 * at(1) + at(2)) / (h * h),
                                 (at(0) - 3 * at(1) + 3 * at(2) - at(3)) / (h * h * h)};
  };
  std::vector<TraceSample> trace(t.samples());
  for (std::size_t n = 0; n < trace.size(); ++n) {
    trace[n].t_s = double(n) * h;
    trace[n].at = tool[n];
    const auto x = differences([&](std::size_t k) { return tool[k].x_mm; }, n),
               y = differences([&](std::size_t k) { return tool[k].y_mm; }, n);
    for (std::size_t k = 0; k < 3; ++k) trace[n].total[k] = std::hypot(x[k], y[k]);
    for (std::size_t a = 0; a < axes; ++a)
      trace[n].joint[a] =
          differences([&](std::size_t k) { return t.positions[k * std::size_t(t.axes) + a]; }, n);
  }
  return trace;
}

std::string plan_picture(const PlanPlot& p) {
  constexpr double kColumn = 440, kRow = 330, kMapRow = 400, kHead = 40;
  const std::size_t rows = 1 + p.joint_names.size();
  const double width = 3 * kColumn + 20, height = kHead + kMapRow + double(rows) * kRow;
  std::string s = fmt::format(
      "<svg viewBox=\"0 0 {:.0f} {:.0f}\" width=\"{:.0f}\" role=\"img\" "
      "xmlns=\"http://www.w3.org/2000/svg\">",
      width, height, width);
  s += "<style>" + std::string(replay::kReportStyle) +
       "svg { background: var(--bg); font-family: system-ui, \"DejaVu Sans\", sans-serif; } .head { "
       "font-size: 18px; fill: var(--fg); }</style>\n";
  s += "<title>" + replay::escape_html(p.title) + "</title>\n" +
       replay::svg_text(width / 2, 26, "middle", "head", p.title);
  s += placed(speed_map(p.trace, p.limits.position.rate, "path coloured by speed"), 10, kHead, kColumn - 16,
              kMapRow - 16);
  s += certificate_table(p.certificate, 40 + kColumn, kHead + 30);
  const std::array<const char*, 3> total{"speed", "acceleration", "jerk"},
      joint{"rate", "acceleration", "jerk"};
  const std::array<const char*, 3> per{"/s", "/s²", "/s³"};
  const std::array<double, 3> limits{p.limits.position.rate, p.limits.position.acceleration,
                                     p.limits.position.jerk};
  for (std::size_t k = 0; k < 3; ++k)
    s += placed(chart(p, std::string("total ") + total[k], std::string("mm") + per[k], limits[k], false,
                      [k](const TraceSample& t) { return t.total[k]; }),
                10 + kColumn * double(k), kHead + kMapRow, kColumn - 16, kRow - 10);
  for (std::size_t j = 0; j < p.joint_names.size(); ++j) {
    const double unit = p.joint_units[j] == "rad" ? kDegrees : 1.0;
    const motion::RateLimits& l = p.limits.joint[j];
    const std::array<double, 3> bound{l.rate * unit, l.acceleration * unit, l.jerk * unit};
    for (std::size_t k = 0; k < 3; ++k)
      s += placed(chart(p, p.joint_names[j] + " " + joint[k],
                        (p.joint_units[j] == "rad" ? "deg" : "mm") + std::string(per[k]), bound[k], true,
                        [j, k, unit](const TraceSample& t) { return t.joint[j][k] * unit; }),
                  10 + kColumn * double(k), kHead + kMapRow + kRow * double(j + 1), kColumn - 16, kRow - 10);
  }
  return s + "</svg>\n";
}

}  // namespace firn
