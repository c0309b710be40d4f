#include "report/run/report_followed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "firn/followed_path_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/path_report_t.hpp"
#include "report/draw/charts.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr double kUmOfMm = 1e3;
constexpr double kMsOfS = 1e3;
constexpr double kDrawnShare = 0.03;  // of the path's extent: the largest deviation as drawn

struct Extent {
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  void add(const Point2& p) {
    x0 = std::min(x0, p.x_mm);
    x1 = std::max(x1, p.x_mm);
    y0 = std::min(y0, p.y_mm);
    y1 = std::max(y1, p.y_mm);
  }
  double size() const { return std::max({x1 - x0, y1 - y0, 1e-6}); }
};

// The largest of 1, 2, 5, 10, ... that keeps the deviations small against the path.
double enlargement(const FollowedLayer& l, double extent_mm) {
  double most = 1e-6;
  for (const Point2& e : l.beside) most = std::max(most, std::hypot(e.x_mm, e.y_mm));
  double by = 1.0;
  for (double step = 1.0; step < 1e6; step *= 10.0)
    for (const double of : {1.0, 2.0, 5.0})
      if (of * step * most <= kDrawnShare * extent_mm) by = of * step;
  return by;
}

std::string polyline(const std::vector<Point2>& points, const Extent& e, double scale, const char* style) {
  std::string d;
  char text[64];
  for (const Point2& p : points) {
    std::snprintf(text, sizeof text, "%s%.2f %.2f", d.empty() ? "M" : "L", 10.0 + (p.x_mm - e.x0) * scale,
                  10.0 + (e.y1 - p.y_mm) * scale);
    d += text;
  }
  return "<path fill=\"none\" " + std::string(style) + " d=\"" + d + "\"/>";
}

std::string path_figure(const NamedPaths& run) {
  const FollowedLayer& l = run.layers->back();
  Extent extent;
  for (const Point2& p : l.planned) extent.add(p);
  constexpr double kSide = 400.0;
  const double scale = kSide / extent.size(), by = enlargement(l, extent.size());
  std::vector<Point2> shown;
  for (std::size_t k = 0; k < l.planned.size(); ++k)
    shown.push_back({l.planned[k].x_mm + by * l.beside[k].x_mm, l.planned[k].y_mm + by * l.beside[k].y_mm});
  const std::string title = run.name + ", layer " + std::to_string(l.layer) +
                            ": deviation across the path, " + number(by, 0) + " times";
  return "<figure><figcaption>" + escape_html(title) + "</figcaption>\n" +
         svg_open(20.0 + (extent.x1 - extent.x0) * scale, 20.0 + (extent.y1 - extent.y0) * scale, title) +
         polyline(l.planned, extent, scale, "stroke=\"var(--soft)\" stroke-width=\"3\" opacity=\"0.45\"") +
         polyline(shown, extent, scale, "stroke=\"var(--bad)\" stroke-width=\"1\"") + "</svg></figure>\n";
}

std::string cell_of(double value, int decimals) { return "<td>" + number(value, decimals) + "</td>"; }

}  // namespace

std::vector<FollowedLayer> read_followed(const runs::RunMessages& messages) {
  std::map<std::int64_t, line_plan_t> plans;
  std::map<std::int64_t, followed_path_t> paths;
  messages.each<line_plan_t>(channels::kLinePlan.name, [&](const line_plan_t& m) {
    if (m.path > 0) plans[m.path] = m;
  });
  messages.each<followed_path_t>(channels::kFollowedPath.name,
                                 [&](const followed_path_t& m) { paths[m.path] = m; });
  std::vector<FollowedLayer> layers;
  messages.each<path_report_t>(channels::kPathReport.name, [&](const path_report_t& r) {
    const auto plan = plans.find(r.path);
    const auto path = paths.find(r.path);
    if (r.samples == 0 || plan == plans.end() || path == paths.end()) return;
    const line_plan_t& p = plan->second;
    std::vector<PathKnot> knots;
    for (std::size_t k = 0; k < p.t_s.size(); ++k)
      knots.push_back({p.t_s[k], p.x_mm[k], p.y_mm[k], p.vx_mm_s[k], p.vy_mm_s[k]});
    const TimedPath timed(std::move(knots));
    const followed_path_t& f = path->second;
    std::vector<Point2> followed;
    FollowedLayer l;
    l.layer = r.layer;
    for (std::size_t k = 0; k < f.x_mm.size(); ++k) {
      followed.push_back({double(f.x_mm[k]), double(f.y_mm[k])});
      const PathKnot at = timed.at(double(k) * f.period_s);
      Point2 off{followed[k].x_mm - at.x_mm, followed[k].y_mm - at.y_mm};
      const double speed2 = at.vx_mm_s * at.vx_mm_s + at.vy_mm_s * at.vy_mm_s;
      if (speed2 > 0.0) {
        const double along = (off.x_mm * at.vx_mm_s + off.y_mm * at.vy_mm_s) / speed2;
        off = {off.x_mm - along * at.vx_mm_s, off.y_mm - along * at.vy_mm_s};
      }
      l.planned.push_back({at.x_mm, at.y_mm});
      l.beside.push_back(off);
      l.time_s.push_back(double(k) * f.period_s);
    }
    l.contour_um = contour_errors_mm(timed, f.period_s, followed);
    for (double& um : l.contour_um) um *= kUmOfMm;
    l.contour_max_um = kUmOfMm * r.contour_max_mm;
    l.contour_rms_um = kUmOfMm * r.contour_rms_mm;
    l.following_max_um = kUmOfMm * r.following_max_mm;
    l.lag_ms = kMsOfS * r.lag_max_s;
    l.switch_um = kUmOfMm * r.switch_max_mm;
    l.offset_rms_um = kUmOfMm * r.offset_rms_mm;
    layers.push_back(std::move(l));
  });
  return layers;
}

std::string followed_sections(const std::vector<NamedPaths>& runs) {
  std::vector<Series> contour;
  std::string figures, rows;
  for (const NamedPaths& run : runs) {
    if (run.layers->empty()) continue;
    const FollowedLayer& last = run.layers->back();
    contour.push_back({run.name, last.time_s, last.contour_um, run.style});
    figures += path_figure(run);
    for (const FollowedLayer& l : *run.layers)
      rows += "<tr><td>" + escape_html(run.name) + "</td><td>" + std::to_string(l.layer) + "</td><td>" +
              std::to_string(l.time_s.size()) + "</td>" + cell_of(l.contour_max_um, 2) +
              cell_of(l.contour_rms_um, 2) + cell_of(l.following_max_um, 1) + cell_of(l.lag_ms, 2) +
              cell_of(l.switch_um, 2) + cell_of(l.offset_rms_um, 2) + "</tr>\n";
  }
  if (rows.empty()) return "";
  ChartOptions o{"contour error", "time along the path [s]", "contour error [µm]"};
  o.from_zero = true;
  o.legend = false;
  return "<h2>Followed path</h2>\n<p class=\"soft\">Position feedback of X and Y, recorded by the stage's "
         "controller, against the planned path of the last layer. Contour error: distance from the planned "
         "path, "
         "whenever it was passed.</p>\n<div class=\"row\">\n" +
         figures + "<figure><figcaption>Contour error along the path</figcaption>\n" +
         line_chart(contour, o) +
         "</figure>\n</div>\n"
         "<table><tr><th>run</th><th>layer</th><th>samples</th><th>contour error, largest [µm]</th>"
         "<th>RMS [µm]</th><th>following error, largest [µm]</th><th>lag, largest [ms]</th>"
         "<th>place of a switch [µm]</th><th>middles from the lines, RMS [µm]</th></tr>\n" +
         rows + "</table>\n";
}

}  // namespace firn::report
