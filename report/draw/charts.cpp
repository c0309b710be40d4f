#include "report/draw/charts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <tuple>

#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr double kWidth = 424, kLegendRow = 20;
constexpr const char* kDashes[] = {"none", "9 4", "2 3", "9 3 2 3", "14 4", "5 2"};

// Each further six lines have the colours with other dashes and marks: no two of 36 look the same.
int dash_of(int style) { return (style + style / 6) % 6; }
int mark_of(int style) { return (style + style / 6) % 3; }

std::string style_of(int style) {
  if (style == Series::kReference)
    return "stroke=\"var(--fg)\" stroke-dasharray=\"5 4\" stroke-width=\"1.4\"";
  return "stroke=\"var(--c" + std::to_string(style % 6) + ")\" stroke-dasharray=\"" +
         kDashes[dash_of(style)] + "\" stroke-width=\"2\"";
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void take(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  void settle() {
    if (low > high) {
      low = 0;
      high = 1;
    }
  }
};

std::string mark(int style, double x, double y) {
  char text[160];
  const int color = style % 6;
  switch (mark_of(style)) {
    case 0:
      std::snprintf(text, sizeof text, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\" fill=\"var(--c%d)\"/>", x,
                    y, color);
      break;
    case 1:
      std::snprintf(text, sizeof text,
                    "<rect x=\"%.1f\" y=\"%.1f\" width=\"5\" height=\"5\" fill=\"var(--c%d)\"/>", x - 2.5,
                    y - 2.5, color);
      break;
    default:
      std::snprintf(text, sizeof text, "<path d=\"M%.1f %.1fl3.4 5.8h-6.8z\" fill=\"var(--c%d)\"/>", x,
                    y - 3.6, color);
  }
  return text;
}

std::string line_sample(int style, bool marks) {
  return "<path d=\"M0 0h26\" " + style_of(style) + "/>" + (marks ? mark(style, 13, 0) : "");
}

std::string bar_sample(int part) {
  return "<rect x=\"8\" y=\"-6\" width=\"16\" height=\"12\" fill=\"var(--p" + std::to_string(part) + ")\"/>";
}

std::string draw_line(const Series& s, const Axis& x, const Axis& y) {
  std::string d, marks;
  bool pen_down = false;
  for (std::size_t n = 0; n < s.x.size(); ++n) {
    if (!std::isfinite(s.y[n])) {
      pen_down = false;
      continue;
    }
    char point[48];
    const double px = x.px(s.x[n]), py = y.px(s.y[n]);
    std::snprintf(point, sizeof point, "%c%.1f %.1f", pen_down ? 'L' : 'M', px, py);
    d += point;
    pen_down = true;
    if (s.marks) marks += mark(s.style, px, py);
  }
  return "<path fill=\"none\" stroke-linejoin=\"round\" " + style_of(s.style) + " d=\"" + d + "\"/>" + marks +
         "\n";
}

std::string draw_band(const Series& s, const Axis& x, const Axis& y) {
  std::string out, there, back;
  const auto close = [&] {
    if (!there.empty())
      out += "<path fill-opacity=\"0.16\" fill=\"var(--c" + std::to_string(std::max(0, s.style) % 6) +
             ")\" d=\"M" + there.substr(1) + back + "Z\"/>\n";
    there.clear();
    back.clear();
  };
  for (std::size_t n = 0; n < s.low.size(); ++n) {
    if (!std::isfinite(s.low[n]) || !std::isfinite(s.high[n])) {
      close();
      continue;
    }
    char point[48];
    std::snprintf(point, sizeof point, "L%.1f %.1f", x.px(s.x[n]), y.px(s.low[n]));
    there += point;
    std::snprintf(point, sizeof point, "L%.1f %.1f", x.px(s.x[n]), y.px(s.high[n]));
    back = point + back;
  }
  close();
  return out;
}

struct Entry {
  std::string sample, label;
};

int legend_columns(const std::vector<Entry>& entries) {
  std::size_t longest = 1;
  for (const Entry& e : entries) longest = std::max(longest, e.label.size());
  return std::clamp(int((kWidth - 54) / (44 + 6.6 * double(longest))), 1, 4);
}

double legend_height(const std::vector<Entry>& entries) {
  const int columns = legend_columns(entries);
  return double((int(entries.size()) + columns - 1) / columns) * kLegendRow;
}

// Below the chart, in as many columns as the labels leave room for.
std::string legend(const std::vector<Entry>& entries, double top) {
  const int columns = legend_columns(entries);
  std::string s;
  for (std::size_t n = 0; n < entries.size(); ++n) {
    const double x = 54 + double(int(n) % columns) * (kWidth - 54) / columns,
                 y = top + double(int(n) / columns) * kLegendRow;
    char open[64];
    std::snprintf(open, sizeof open, "<g transform=\"translate(%.1f %.1f)\">", x, y);
    s += open + entries[n].sample + svg_text(32, 4, "start", "tick", entries[n].label) + "</g>\n";
  }
  return s;
}

}  // namespace

std::string line_chart(const std::vector<Series>& series, const ChartOptions& o) {
  Range rx, ry;
  for (const Series& s : series)
    for (std::size_t n = 0; n < s.x.size(); ++n) {
      rx.take(s.x[n]);
      if (!o.logarithmic || s.y[n] > 0) ry.take(s.y[n]);
      if (s.low.empty()) continue;
      if (!o.logarithmic || s.low[n] > 0) ry.take(s.low[n]);
      ry.take(s.high[n]);
    }
  if (o.from_zero) ry.take(0);
  rx.settle();
  ry.settle();
  if (o.y_range) std::tie(ry.low, ry.high) = *o.y_range;
  const bool logarithmic = o.logarithmic && ry.low > 0;
  if (logarithmic) {
    ry.low *= 0.9;
    ry.high *= 1.1;
  }
  if (!logarithmic && !o.y_range) ry.high += 0.06 * (ry.high - ry.low);
  std::vector<Entry> entries;
  if (o.legend)
    for (const Series& line : series) entries.push_back({line_sample(line.style, line.marks), line.label});
  constexpr const char* kShade = "fill=\"var(--soft)\" fill-opacity=\"0.18\"/>";
  if (o.legend && !o.shaded_label.empty())
    entries.push_back(
        {std::string("<rect x=\"4\" y=\"-6\" width=\"20\" height=\"12\" ") + kShade, o.shaded_label});
  const Frame f;
  const Axis x(rx.low, rx.high, f.left, f.right, 6, o.whole_x ? Axis::Kind::kWhole : Axis::Kind::kLinear);
  const Axis y(ry.low, ry.high, f.bottom, f.top, 6,
               logarithmic ? Axis::Kind::kLogarithmic : Axis::Kind::kLinear);
  std::string s = svg_open(kWidth, f.bottom + 48 + legend_height(entries), o.title);
  for (const auto& [from, to] : o.shaded) {
    char rect[120];
    std::snprintf(rect, sizeof rect, "<rect x=\"%.2f\" y=\"%.1f\" width=\"%.2f\" height=\"%.1f\" ",
                  x.px(from), f.top, x.px(to) - x.px(from), f.bottom - f.top);
    s += std::string(rect) + kShade + "\n";
  }
  s += draw_axes(f, x, y, o.x_name, o.y_name);
  char clip[200];  // lines that leave a given range end at the frame
  std::snprintf(clip, sizeof clip,
                "<svg x=\"0\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" viewBox=\"0 %.1f %.1f %.1f\">", f.top,
                f.right + 6, f.bottom - f.top, f.top, f.right + 6, f.bottom - f.top);
  s += clip;
  for (const Series& line : series) {
    Series drawn = line;
    if (logarithmic)
      for (std::vector<double>* values : {&drawn.y, &drawn.low})
        for (double& v : *values)
          if (!(v > 0)) v = std::numeric_limits<double>::quiet_NaN();
    s += draw_band(drawn, x, y) + draw_line(drawn, x, y);
  }
  return s + "</svg>\n" + legend(entries, f.bottom + 52) + "</svg>\n";
}

std::string bar_chart(const Bars& bars, double top, const ChartOptions& o) {
  Range rx;
  for (double v : bars.x) rx.take(v);
  rx.settle();
  std::vector<Entry> entries;
  if (o.legend)
    for (std::size_t p = 0; p < bars.parts.size(); ++p)
      entries.push_back({bar_sample(int(p)), bars.parts[p]});
  const Frame f;
  const Axis x(rx.low - 0.6, rx.high + 0.6, f.left, f.right, 6, Axis::Kind::kWhole);
  const Axis y(0, top * 1.06, f.bottom, f.top, 6);
  std::string s = svg_open(kWidth, f.bottom + 48 + legend_height(entries), o.title);
  s += draw_axes(f, x, y, o.x_name, o.y_name);
  const double width = std::max(0.6, (x.px(1) - x.px(0)) * 0.8);
  for (std::size_t n = 0; n < bars.x.size(); ++n) {
    double below = 0;
    for (std::size_t p = 0; p < bars.parts.size(); ++p) {
      const double height = bars.heights[p][n];
      if (!(height > 0)) continue;
      char rect[200];
      std::snprintf(rect, sizeof rect,
                    "<rect x=\"%.1f\" y=\"%.2f\" width=\"%.1f\" height=\"%.2f\" fill=\"var(--p%zu)\"/>",
                    x.px(bars.x[n]) - width / 2, y.px(below + height), width,
                    y.px(below) - y.px(below + height), p);
      s += rect;
      below += height;
    }
  }
  return s + "\n" + legend(entries, f.bottom + 52) + "</svg>\n";
}

std::string legend_sample(const LegendEntry& e) {
  const bool line = e.kind == LegendEntry::Kind::kLine;
  return "<svg class=\"sample\" width=\"28\" height=\"14\" viewBox=\"-1 -7 28 14\" aria-hidden=\"true\">" +
         (line ? line_sample(e.style, e.style != Series::kReference) : bar_sample(e.style)) + "</svg>";
}

std::string shared_legend(const std::vector<LegendEntry>& entries) {
  std::string s = "<p class=\"legend\">";
  for (const LegendEntry& e : entries)
    s += "<span>" + legend_sample(e) + " " + escape_html(e.label) + "</span>\n";
  return s + "</p>\n";
}

}  // namespace firn::report
