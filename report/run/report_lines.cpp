#include "report/run/report_lines.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "firn/enums.h"
#include "firn/line_plan_t.hpp"
#include "report/draw/charts.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr double kUm2PerMm2 = 1e6;  // per mm^2
constexpr double kMinHalfRange = 0.1;

constexpr const char* kByCamera =
    "Heights were not measured: this lab has a camera and no profiler. The width is that at half contrast in "
    "its pictures; starts and ends are those of the ink that a layer added, where the lines are not too dark "
    "to "
    "tell.";
constexpr const char* kByProfiler =
    "As measured by the profiler after the last layer: the section of all layers, and the full width at half "
    "height. Gaps: stations that another line is too near to.";
constexpr const char* kLayersBegin =
    "<p class=\"soft\">Layer by layer: mean section of the layer; how much later its free lines began and "
    "how much farther they ended; shutter delays and flow that the next layer was planned with.</p>\n"
    "<table><tr><th>run</th><th>layer</th><th>section [µm²]</th><th>start [µm]</th><th>end [µm]</th>"
    "<th>open delay [ms]</th><th>close delay [ms]</th><th>flow</th><th>sheath gas</th>"
    "<th>gaps, camera [µm]</th></tr>\n";

std::vector<double> scaled_values(const std::vector<float>& values, double by) {
  std::vector<double> out;
  for (const float v : values) out.push_back(double(v) * by);
  return out;
}

std::string cell_text(double value, const char* format) {
  if (std::isnan(value)) return "–";
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string chart_along(const char* title, const char* y_name, const std::vector<Series>& runs) {
  ChartOptions o{title, "way along the lines [mm]", y_name};
  o.legend = false;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& run : runs)
    for (const double y : run.y)
      if (std::isfinite(y)) {
        low = std::min(low, y);
        high = std::max(high, y);
      }
  if (low <= high) {  // noise of a per cent does not fill the chart
    const double middle = 0.5 * (low + high), half = std::max(0.6 * (high - low), kMinHalfRange * middle);
    o.y_range = {middle - half, middle + half};
  }
  return std::string("<figure><figcaption>") + title + "</figcaption>\n" + line_chart(runs, o) +
         "</figure>\n";
}

}  // namespace

std::optional<SurfaceCut> line_cut(const PrintJob& job) {
  constexpr double kEitherSide_mm = 1.0;
  double longest = 0.0;
  std::optional<SurfaceCut> cut;
  for (const PrintSegment& s : job.segments) {
    const double dx = s.to.x_mm - s.from.x_mm, dy = s.to.y_mm - s.from.y_mm, length = std::hypot(dx, dy);
    if (!(length > longest)) continue;
    longest = length;
    cut = {0.5 * (s.from.x_mm + s.to.x_mm),
           0.5 * (s.from.y_mm + s.to.y_mm),
           -dy / length,
           dx / length,
           -kEitherSide_mm,
           kEitherSide_mm};
  }
  return cut;
}

LineData read_line_data(const runs::RunMessages& messages) {
  LineData data;
  messages.each<line_plan_t>(channels::kLinePlan.name, [&](const line_plan_t& m) {
    if (data.way_mm.size() != m.station_x_mm.size()) {
      data.way_mm.clear();
      double way = 0.0;
      for (std::size_t s = 0; s < m.station_x_mm.size(); ++s) {
        if (s > 0)
          way += std::hypot(double(m.station_x_mm[s]) - double(m.station_x_mm[s - 1]),
                            double(m.station_y_mm[s]) - double(m.station_y_mm[s - 1]));
        data.way_mm.push_back(way);
      }
    }
    if (m.layer < 2) return;
    LineLayer l;
    l.layer = m.layer - 1;
    l.area_um2 = scaled_values(m.area_mm2, kUm2PerMm2);
    l.layer_area_um2 = scaled_values(m.layer_area_mm2, kUm2PerMm2);
    l.width_um = scaled_values(m.width_mm, 1e3);
    l.seen_width_um = scaled_values(m.seen_width_mm, 1e3);
    for (const float gap : m.seen_gap_mm)
      if (!std::isnan(gap)) l.gap_um += double(gap) * 1e3;
    l.start_error_um = m.start_error_mm * 1e3;
    l.end_error_um = m.end_error_mm * 1e3;
    const bool planned = PlanDecision(m.decision) == PlanDecision::kPrint;
    l.open_delay_ms = planned ? m.open_delay_s * 1e3 : NAN;
    l.close_delay_ms = planned ? m.close_delay_s * 1e3 : NAN;
    l.flow_share = planned ? m.flow_share : NAN;
    l.sheath_share = planned ? m.sheath_share : NAN;
    const auto at = std::ranges::find(data.layers, l.layer, &LineLayer::layer);
    at == data.layers.end() ? data.layers.push_back(std::move(l)) : void(*at = std::move(l));
  });
  data.followed = read_followed(messages);
  return data;
}

std::string line_sections(const std::vector<NamedLines>& runs) {
  std::vector<Series> area, width, seen;
  std::vector<NamedPaths> paths;
  std::string table;
  for (const NamedLines& r : runs) {
    paths.push_back({r.name, &r.data->followed, r.style});
    if (r.data->layers.empty()) continue;
    const LineLayer& last = r.data->layers.back();
    if (std::ranges::any_of(last.area_um2, [](double a) { return !std::isnan(a); })) {
      area.push_back({r.name, r.data->way_mm, last.area_um2, r.style});
      width.push_back({r.name, r.data->way_mm, last.width_um, r.style});
    }
    if (!last.seen_width_um.empty()) seen.push_back({r.name, r.data->way_mm, last.seen_width_um, r.style});
    for (const LineLayer& l : r.data->layers) {
      double sum = 0.0, n = 0.0;
      for (const double a : l.layer_area_um2)
        if (!std::isnan(a)) {
          sum += a;
          n += 1.0;
        }
      table += "<tr><td>" + escape_html(r.name) + "</td><td>" + std::to_string(l.layer) + "</td><td>" +
               cell_text(n > 0.0 ? sum / n : NAN, "%.0f") + "</td><td>" +
               cell_text(l.start_error_um, "%.0f") + "</td><td>" + cell_text(l.end_error_um, "%.0f") +
               "</td><td>" + cell_text(l.open_delay_ms, "%.1f") + "</td><td>" +
               cell_text(l.close_delay_ms, "%.1f") + "</td><td>" + cell_text(l.flow_share, "%.3f") +
               "</td><td>" + cell_text(l.sheath_share, "%.3f") + "</td><td>" +
               cell_text(l.seen_width_um.empty() ? NAN : l.gap_um, "%.0f") + "</td></tr>\n";
    }
  }
  if (table.empty()) return followed_sections(paths);
  std::string charts;
  if (!area.empty())
    charts += chart_along("Cross-section", "section [µm²]", area) +
              chart_along("Width at half height", "width [µm]", width);
  if (!seen.empty()) charts += chart_along("Width at half contrast, by the camera", "width [µm]", seen);
  return std::string("<h2>Lines</h2>\n<p class=\"soft\">") + (area.empty() ? kByCamera : kByProfiler) +
         "</p>\n<div class=\"row\">\n" + charts + "</div>\n" + kLayersBegin + table + "</table>\n" +
         followed_sections(paths);
}

}  // namespace firn::report
