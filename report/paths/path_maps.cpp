#include "report/paths/path_maps.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "report/draw/raster.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

using motion::TraceSample;
using report::Rgba;

/// Cividis at five points: legible without colour vision and on paper.
Rgba cividis(double share) {
  constexpr std::array<std::array<double, 3>, 5> stops{
      {{0, 34, 78}, {65, 77, 107}, {124, 123, 120}, {188, 175, 111}, {254, 232, 56}}};
  const double x = std::clamp(share, 0.0, 1.0) * 4.0;
  const std::size_t i = std::min<std::size_t>(3, std::size_t(x));
  Rgba c{0, 0, 0, 255};
  for (std::size_t k = 0; k < 3; ++k)
    c[k] = std::uint8_t(std::lround(stops[i][k] + (stops[i + 1][k] - stops[i][k]) * (x - double(i))));
  return c;
}

std::string colour(double share) {
  const Rgba c = cividis(share);
  return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
}

std::string colour_bar(double left, double top, double width, const PathColours& colours) {
  constexpr int kSteps = 60, kTicks = 4;
  std::string s;
  for (int n = 0; n < kSteps; ++n)
    s += fmt::format("<rect x=\"{:.1f}\" y=\"{:.0f}\" width=\"{:.1f}\" height=\"12\" fill=\"{}\"/>",
                     left + width * n / kSteps, top, width / kSteps + 0.4, colour((n + 0.5) / kSteps));
  for (int n = 0; n <= kTicks; ++n) {
    const bool last = n == kTicks;  // ends with the picture, however long
    s += report::svg_text(left + width * n / kTicks + (last ? 8.0 : 0.0), top + 28, last ? "end" : "middle",
                          "tick", report::number(colours.top * n / kTicks, colours.decimals));
  }
  return s + report::svg_text(left + width / 2, top + 46, "middle", "name", colours.name);
}

double to_segment(Point2 p, Point2 a, Point2 b) {
  const double x = b.x_mm - a.x_mm, y = b.y_mm - a.y_mm, square = x * x + y * y;
  const double t =
      square > 0.0 ? std::clamp(((p.x_mm - a.x_mm) * x + (p.y_mm - a.y_mm) * y) / square, 0.0, 1.0) : 0.0;
  return distance(p, {a.x_mm + t * x, a.y_mm + t * y});
}

}  // namespace

std::string path_map(const std::vector<TraceSample>& trace, const PathColours& colours,
                     const std::vector<Point2>& points, const std::string& title) {
  constexpr double kWidth = 424, kHeight = 380, kBarTop = 330;
  constexpr std::size_t kPieces = 800;
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  for (const TraceSample& t : trace) {
    x0 = std::min(x0, t.at.x_mm);
    x1 = std::max(x1, t.at.x_mm);
    y0 = std::min(y0, t.at.y_mm);
    y1 = std::max(y1, t.at.y_mm);
  }
  report::Frame f{54, 10, 414, 262};
  // One scale for both axes: a circle stays a circle.
  const double room_x = f.right - f.left - 20, room_y = f.bottom - f.top - 20;
  const double scale = std::max({(x1 - x0) / room_x, (y1 - y0) / room_y, 1e-6});
  const double half_x = 0.5 * scale * (f.right - f.left), half_y = 0.5 * scale * (f.bottom - f.top);
  const report::Axis x(0.5 * (x0 + x1) - half_x, 0.5 * (x0 + x1) + half_x, f.left, f.right, 6);
  const report::Axis y(0.5 * (y0 + y1) - half_y, 0.5 * (y0 + y1) + half_y, f.bottom, f.top, 6);
  std::string s = report::svg_open(kWidth, kHeight, title) + report::draw_axes(f, x, y, "x [mm]", "y [mm]");
  s += "<g fill=\"none\" stroke-width=\"4\" stroke-linecap=\"round\">\n";
  const std::size_t step = std::max<std::size_t>(1, trace.size() / kPieces);
  for (std::size_t n = 0; n + 1 < trace.size(); n += step) {
    const std::size_t last = std::min(n + step, trace.size() - 1);
    const TraceSample &a = trace[n], &b = trace[last];
    if (b.s_mm < a.s_mm) continue;  // another path begins
    s += fmt::format("<path stroke=\"{}\" d=\"M{:.2f} {:.2f}L{:.2f} {:.2f}\"/>",
                     colour(0.5 * (colours.value[n] + colours.value[last]) / colours.top), x.px(a.at.x_mm),
                     y.px(a.at.y_mm), x.px(b.at.x_mm), y.px(b.at.y_mm));
  }
  s += "</g>\n";
  if (points.size() > 1) {
    s += "<path class=\"polygon\" fill=\"none\" stroke=\"var(--fg)\" stroke-width=\"0.6\" d=\"";
    const std::size_t every = std::max<std::size_t>(1, points.size() / (4 * kPieces));
    for (std::size_t n = 0; n < points.size(); n += n + every < points.size() ? every : points.size() - n)
      s += fmt::format("{}{:.2f} {:.2f}", n == 0 ? 'M' : 'L', x.px(points[n].x_mm), y.px(points[n].y_mm));
    s += "\"/>\n";
  }
  return s + colour_bar(f.left, kBarTop, f.right - f.left, colours) + "</svg>\n";
}

std::vector<double> along_path(const std::vector<TraceSample>& trace) {
  std::vector<double> along;
  const bool known = !trace.empty() && trace.back().s_mm > 0.0;
  for (std::size_t n = 0; n < trace.size(); ++n)
    along.push_back(known    ? trace[n].s_mm
                    : n == 0 ? 0.0
                             : along.back() + distance(trace[n - 1].at, trace[n].at));
  return along;
}

std::vector<double> deviations(const std::vector<TraceSample>& trace, const std::vector<Point2>& points) {
  constexpr double kWindowMm = 2.0, kWindowShare = 0.02;  // to either side of the same share of the length
  std::vector<double> length{0.0};
  for (std::size_t i = 1; i < points.size(); ++i)
    length.push_back(length.back() + distance(points[i - 1], points[i]));
  const std::vector<double> along = along_path(trace);
  const double scale = along.empty() || along.back() == 0.0 ? 0.0 : length.back() / along.back();
  const double window = kWindowMm + kWindowShare * length.back();
  std::vector<double> out;
  std::size_t first = 0;
  for (std::size_t n = 0; n < trace.size(); ++n) {
    const double here = scale * along[n];
    while (first + 2 < points.size() && length[first + 1] < here - window) ++first;
    double nearest = 1e300;
    for (std::size_t i = first; i + 1 < points.size() && length[i] <= here + window; ++i)
      nearest = std::min(nearest, to_segment(trace[n].at, points[i], points[i + 1]));
    out.push_back(nearest);
  }
  return out;
}

std::string limit_strips(const std::vector<double>& along_mm, const std::vector<LimitActivity>& limits,
                         double width, const std::string& title) {
  constexpr double kLeft = 150, kRight = 16, kTop = 10, kRow = 20, kGap = 3, kBelow = 110;
  constexpr int kColumns = 500;
  constexpr Rgba kAbove{213, 94, 0, 255};
  const double bottom = kTop + kRow * double(limits.size()), right = width - kRight;
  std::string s = report::svg_open(width, bottom + kBelow, title);
  const double length = along_mm.empty() ? 1.0 : std::max(along_mm.back(), 1e-9);
  for (std::size_t k = 0; k < limits.size(); ++k) {
    std::vector<double> most(kColumns, -1.0);
    for (std::size_t n = 0; n < along_mm.size(); ++n) {
      const int column = std::clamp(int(kColumns * along_mm[n] / length), 0, kColumns - 1);
      most[std::size_t(column)] = std::max(most[std::size_t(column)], limits[k].share[n]);
    }
    report::Raster strip(kColumns, 1);
    double before = 0.0;
    for (int c = 0; c < kColumns; ++c) {
      if (most[std::size_t(c)] >= 0.0) before = most[std::size_t(c)];
      constexpr double kRounding = 1e-6;
      strip.at(c, 0) = before > 1.0 + kRounding ? kAbove : cividis(before);
    }
    const double top = kTop + kRow * double(k);
    s += report::svg_image(strip, kLeft, top, right - kLeft, kRow - kGap);
    s += report::svg_text(kLeft - 8, top + 13, "end", "name", limits[k].name);
  }
  const report::Axis x(0.0, length, kLeft, right, 8);
  for (const auto& tick : x.ticks())
    s += report::svg_text(x.px(tick.value), bottom + 16, "middle", "tick", tick.text);
  s += report::svg_text((kLeft + right) / 2, bottom + 34, "middle", "name", "along the path [mm]");
  const PathColours bar{{}, 1.0, "share of the limit (orange: above it)", 2};
  return s + colour_bar(kLeft, bottom + 48, 0.5 * (right - kLeft), bar) + "</svg>\n";
}

}  // namespace firn::report
