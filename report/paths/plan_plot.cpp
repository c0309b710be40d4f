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
#include "report/paths/path_maps.h"
#include "report/run/report_page.h"

namespace firn::report {
namespace {

using motion::TraceSample;

constexpr std::size_t kPoints = 600;  // columns of a chart; each keeps its minimum and maximum
constexpr double kUm = 1e3;           // per mm
constexpr double kMinUm = 1e-3;       // top of a deviation's axis
constexpr double kDegrees = 180.0 / std::numbers::pi;

report::Series drawn(const std::vector<TraceSample>& trace,
                     const std::function<double(const TraceSample&)>& value) {
  report::Series line;
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
report::Series limit_line(double from_s, double to_s, double value, bool both_sides) {
  report::Series line{"limit", {from_s, to_s}, {value, value}, report::Series::kReference};
  if (!both_sides) return line;
  line.x.insert(line.x.end(), {to_s, from_s, to_s});
  line.y.insert(line.y.end(), {std::nan(""), -value, -value});
  return line;
}

std::string chart(const PlanPlot& p, double to_s, const std::string& name, const std::string& unit,
                  double limit, bool signed_values, const std::function<double(const TraceSample&)>& value) {
  std::vector<report::Series> series{drawn(p.trace, value)};
  series[0].label = name;
  if (std::isfinite(limit)) series.push_back(limit_line(p.trace.front().t_s, to_s, limit, signed_values));
  report::ChartOptions options;
  options.title = name;
  options.x_name = "time [s]";
  options.y_name = unit;
  options.from_zero = !signed_values;  // the legend has the name
  // Motions that stay below their limit are drawn to its scale; the others show by how much they leave it.
  double reach = std::isfinite(limit) ? limit : 1e-9;
  for (double y : series[0].y) reach = std::max(reach, std::abs(y));
  options.y_range = std::pair(signed_values ? -1.08 * reach : 0.0, 1.08 * reach);
  return report::line_chart(series, options);
}

std::string placed(const std::string& svg, double x, double y, double width, double height) {
  return fmt::format(
             "<svg x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" overflow=\"visible\">", x, y,
             width, height) +
         svg + "</svg>\n";
}

/// Over the distance along the path.
std::string deviation_chart(const PlanPlot& p, const std::vector<double>& along_mm,
                            const std::vector<double>& off_mm) {
  const std::size_t step = std::max<std::size_t>(1, along_mm.size() / kPoints);
  report::Series line{"deviation", {}, {}};
  for (std::size_t n = 0; n < along_mm.size(); n += step) {
    const std::size_t end = std::min(n + step, along_mm.size());
    const auto most =
        std::max_element(off_mm.begin() + std::ptrdiff_t(n), off_mm.begin() + std::ptrdiff_t(end));
    line.x.push_back(along_mm[n]);
    line.y.push_back(kUm * *most);
  }
  const double bound = kUm * p.deviation_mm;
  const report::Series proved{"bound", {0.0, along_mm.back()}, {bound, bound}, report::Series::kReference};
  report::ChartOptions options;
  options.title = "deviation";
  options.x_name = "along the path [mm]";
  options.y_name = "off the path as given [um]";
  options.from_zero = true;
  // rounding alone is no shape to look at
  if (std::max(bound, *std::max_element(line.y.begin(), line.y.end())) < kMinUm)
    options.y_range = {0.0, kMinUm};
  return report::line_chart({line, proved}, options);
}

std::vector<LimitActivity> activities(const PlanPlot& p) {
  std::vector<LimitActivity> all;
  const std::array<const char*, 3> total{"speed", "acceleration", "jerk"},
      joint{"rate", "acceleration", "jerk"};
  const auto add = [&](const std::string& name, double limit, const auto& value) {
    if (!std::isfinite(limit)) return;
    LimitActivity& row = all.emplace_back(LimitActivity{name, {}});
    for (const TraceSample& t : p.trace) row.share.push_back(std::abs(value(t)) / limit);
  };
  const auto of = [](const motion::RateLimits& l) {
    return std::array<double, 3>{l.rate, l.acceleration, l.jerk};
  };
  for (std::size_t k = 0; k < 3; ++k)
    add(std::string("total ") + total[k], of(p.limits.position)[k],
        [k](const TraceSample& t) { return t.total[k]; });
  for (std::size_t j = 0; j < p.joint_names.size(); ++j)
    for (std::size_t k = 0; k < 3; ++k)
      add(p.joint_names[j] + " " + joint[k], of(p.limits.joint[j])[k],
          [j, k](const TraceSample& t) { return t.joint[j][k]; });
  return all;
}

std::string certificate_table(const Certificate& c, double left, double top) {
  std::string s;
  int n = 0;
  const auto row = [&](const std::string& name, const std::string& ratio, const std::string& at) {
    const double y = top + 24.0 * n++;
    s += report::svg_text(left, y, "start", "name", name) +
         report::svg_text(left + 300, y, "end", "name", ratio) +
         report::svg_text(left + 420, y, "end", "name", at);
  };
  row("limit", "largest ratio", "at [s]");
  for (const LimitRatio& l : c.limits) row(l.limit, report::number(l.ratio, 4), report::number(l.time_s, 3));
  row("duration", report::number(c.duration_s, 3) + " s", "");
  if (c.lower_bound_s > 0.0) row("lower bound", report::number(c.lower_bound_s, 3) + " s", "");
  return s;
}

struct Drawing {
  double width, height;
  std::string title, content;
};

/// @param left where it begins; @param to_s end of the axes of time
Drawing drawn_plan(const PlanPlot& p, double left, double to_s) {
  constexpr double kColumn = 440, kRow = 330, kMapRow = 400, kHead = 40;
  const std::vector<double> along = along_path(p.trace);
  const std::vector<LimitActivity> limits = activities(p);
  const double strips = std::max(kRow, 20.0 * double(limits.size()) + 140.0);
  const std::size_t rows = 1 + p.joint_names.size();
  Drawing d{3 * kColumn + 20, kHead + kMapRow + strips + double(rows) * kRow, p.title, {}};
  const auto put = [&](const std::string& svg, double x, double y, double width, double height) {
    d.content += placed(svg, left + x, y, width, height);
  };
  d.content += report::svg_text(left + d.width / 2, 26, "middle", "head", p.title);
  put(speed_map(p.trace, p.limits.position.rate, "path coloured by speed"), 10, kHead, kColumn - 16,
      kMapRow - 16);
  if (p.points.size() > 1) {
    PathColours off{deviations(p.trace, p.points), kMinUm, "off the path as given [um]", 2};
    put(deviation_chart(p, along, off.value), 10 + 2 * kColumn, kHead + kMapRow, kColumn - 16, kRow - 10);
    for (double& mm : off.value) mm *= kUm;
    off.top =
        std::max({off.top, kUm * p.deviation_mm, *std::max_element(off.value.begin(), off.value.end())});
    if (off.top >= 10.0) off.decimals = 1;
    if (off.top < 0.1) off.decimals = 4;
    put(path_map(p.trace, off, p.points, "path coloured by its deviation"), 10 + kColumn, kHead, kColumn - 16,
        kMapRow - 16);
  }
  d.content += certificate_table(p.certificate, left + 10 + 2 * kColumn, kHead + 30);
  put(limit_strips(along, limits, 2 * kColumn - 16, "activity of each limit along the path"), 10,
      kHead + kMapRow, 2 * kColumn - 16, strips - 10);
  const double charts = kHead + kMapRow + strips;
  const std::array<const char*, 3> total{"speed", "acceleration", "jerk"},
      joint{"rate", "acceleration", "jerk"};
  const std::array<const char*, 3> per{"/s", "/s²", "/s³"};
  const std::array<double, 3> bounds{p.limits.position.rate, p.limits.position.acceleration,
                                     p.limits.position.jerk};
  for (std::size_t k = 0; k < 3; ++k)
    put(chart(p, to_s, std::string("total ") + total[k], std::string("mm") + per[k], bounds[k], false,
              [k](const TraceSample& t) { return t.total[k]; }),
        10 + kColumn * double(k), charts, kColumn - 16, kRow - 10);
  for (std::size_t j = 0; j < p.joint_names.size(); ++j) {
    const double unit = p.joint_units[j] == "rad" ? kDegrees : 1.0;
    const motion::RateLimits& l = p.limits.joint[j];
    const std::array<double, 3> bound{l.rate * unit, l.acceleration * unit, l.jerk * unit};
    for (std::size_t k = 0; k < 3; ++k)
      put(chart(p, to_s, p.joint_names[j] + " " + joint[k],
                (p.joint_units[j] == "rad" ? "deg" : "mm") + std::string(per[k]), bound[k], true,
                [j, k, unit](const TraceSample& t) { return t.joint[j][k] * unit; }),
          10 + kColumn * double(k), charts + kRow * double(j + 1), kColumn - 16, kRow - 10);
  }
  return d;
}

std::string standing_alone(const Drawing& d) {
  return fmt::format(
             "<svg viewBox=\"0 0 {:.0f} {:.0f}\" width=\"{:.0f}\" role=\"img\" "
             "xmlns=\"http://www.w3.org/2000/svg\">",
             d.width, d.height, d.width) +
         "<style>" + std::string(report::kReportStyle) +
         "svg { background: var(--bg); font-family: system-ui, \"DejaVu Sans\", sans-serif; } .head { "
         "font-size: 18px; fill: var(--fg); }</style>\n<title>" +
         report::escape_html(d.title) + "</title>\n" + d.content + "</svg>\n";
}

}  // namespace

std::string speed_map(const std::vector<TraceSample>& trace, double top_mm_s, const std::string& title) {
  PathColours speed{{}, top_mm_s, "speed [mm/s]"};
  for (const TraceSample& t : trace) speed.value.push_back(t.total[0]);
  return path_map(trace, speed, {}, title);
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

std::string plan_picture(const PlanPlot& p) { return standing_alone(drawn_plan(p, 0.0, p.trace.back().t_s)); }

std::string plan_pictures_beside(const PlanPlot& left, const PlanPlot& right) {
  const double to_s = std::max(left.trace.back().t_s, right.trace.back().t_s);
  const Drawing a = drawn_plan(left, 0.0, to_s), b = drawn_plan(right, a.width, to_s);
  return standing_alone({a.width + b.width, std::max(a.height, b.height), left.title + " | " + right.title,
                         a.content + b.content});
}

}  // namespace firn::report
