#include "report/run/report_ice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/draw/charts.h"
#include "report/draw/heat_map.h"
#include "report/draw/raster.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr double kMicrons = 1e3;
constexpr std::size_t kMaxMaps = 6;
constexpr double kShown = 0.995;  // of all cells lie within the colour scale

std::string figure(const std::string& caption, const std::string& body, const std::string& cls = "") {
  return "<figure" + (cls.empty() ? "" : " class=\"" + cls + "\"") + "><figcaption>" + caption +
         "</figcaption>\n" + body + "</figure>\n";
}

// The page has one legend for all charts.
ChartOptions from_zero(const char* title, const char* x_name, const char* y_name) {
  ChartOptions o{title, x_name, y_name};
  o.from_zero = true;
  o.legend = false;
  return o;
}

HeightMap error_of(const IceInterval& i) {
  const HeightMap& h = i.truth ? *i.truth : i.height;
  HeightMap e(h.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c)
    if (i.footprint.cells[c]) e.cells[c] = h.cells[c] - i.nominal_mm;
  return e;
}

double rms_mm(const HeightMap& height, const IceInterval& i) {
  return error_stats(height, HeightMap(height.spec, i.nominal_mm), i.footprint).rms_mm;
}

std::string part(const std::vector<NamedIce>& runs) {
  std::string s;
  for (const NamedIce& r : runs)
    if (r.data->field)
      s += figure("<b>" + escape_html(r.name) + "</b>",
                  shaded_relief(*r.data->field, 1.2, "part of " + r.name), "map");
  if (s.empty()) return "";
  return "<h2>Part as built</h2>\n<p class=\"soft\">The true surface, part and scaffold, seen from above; a "
         "contour line every 1.2 mm.</p>\n"
         "<div class=\"row\">\n" +
         s + "</div>\n";
}

// As many intervals as fit a row, evenly over the height, the last among them.
std::vector<std::size_t> chosen(std::size_t n) {
  std::vector<std::size_t> out;
  const std::size_t count = std::min(n, kMaxMaps);
  for (std::size_t k = 1; k <= count; ++k) out.push_back(k * n / count - 1);
  return out;
}

std::string error_maps(const std::vector<NamedIce>& runs) {
  // Single cells beside a tooth's edge are off by far more than all others: they are clipped.
  std::vector<double> sizes;
  for (const NamedIce& r : runs)
    for (const std::size_t k : chosen(r.data->intervals.size()))
      for (const double e : error_of(r.data->intervals[k]).cells)
        if (std::isfinite(e)) sizes.push_back(std::abs(e) * kMicrons);
  if (sizes.empty()) return "";
  const auto at = sizes.begin() + std::ptrdiff_t(kShown * double(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double largest = std::max(*at, 1.0);
  const HeatScale scale{-largest, largest, ColorMap::kDiverging, true};
  std::string s =
      "<h2>Error per interval</h2>\n<p class=\"soft\">True height (measured, where no simulated world told "
      "it) minus nominal over "
      "part and scaffold, as in Fig. 5-8: orange is too high, blue too low.</p>\n";
  for (const NamedIce& r : runs) {
    s += "<h3>" + escape_html(r.name) + "</h3>\n<div class=\"row\">\n";
    for (const std::size_t k : chosen(r.data->intervals.size())) {
      const IceInterval& i = r.data->intervals[k];
      s += figure(number(i.nominal_mm, 2) + " mm, RMS inside " +
                      number(rms_mm(i.truth ? *i.truth : i.height, i)) + " mm",
                  heat_map(error_of(i), scale, "error of " + r.name, &i.footprint), "map");
    }
    s += "</div>\n";
  }
  return s + "<div class=\"bar\">" + color_bar(scale, "height − nominal [mm]") + "</div>\n";
}

std::string rms_by_height(const std::vector<NamedIce>& runs) {
  std::vector<Series> measured, truths, saturated;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    Series m, t, u;
    m.label = t.label = u.label = runs[n].name;
    m.style = t.style = u.style = runs[n].style;
    m.marks = t.marks = u.marks = true;
    for (const IceInterval& i : runs[n].data->intervals) {
      m.x.push_back(i.nominal_mm);
      m.y.push_back(rms_mm(i.height, i));
      u.x.push_back(i.nominal_mm);
      u.y.push_back(100.0 * i.saturated_fraction);
      if (!i.truth) continue;
      t.x.push_back(i.nominal_mm);
      t.y.push_back(rms_mm(*i.truth, i));
    }
    measured.push_back(m);
    if (!t.x.empty()) truths.push_back(t);
    saturated.push_back(u);
  }
  std::string s =
      "<h2>RMS deviation against height</h2>\n<p class=\"soft\">As in Fig. 5-9.</p>\n<div class=\"row\">\n";
  if (!truths.empty())
    s += figure("True surface",
                line_chart(truths, from_zero("true RMS against height", "height [mm]", "RMS [mm]")));
  return s +
         figure("Measured surface",
                line_chart(measured, from_zero("RMS against height", "height [mm]", "RMS [mm]"))) +
         figure("Saturated cells",
                line_chart(saturated, from_zero("saturated cells", "height [mm]", "saturated [%]"))) +
         "</div>\n";
}

std::string curves(const std::vector<NamedIce>& runs) {
  std::string s;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    if (!runs[n].data->curve) continue;
    const IcePathCurve& c = *runs[n].data->curve;
    const std::string what = "<b>" + escape_html(runs[n].name) + "</b>, path " + std::to_string(c.path) +
                             " of layer " + std::to_string(c.layer);
    s += figure(what + ": path speed", line_chart({{"planned", c.time_s, c.speed_mm_s, runs[n].style, false}},
                                                  from_zero("path speed", "t [s]", "c [mm/s]")));
    if (!c.pulse_s.empty())
      s += figure(what + ": valve frequency",
                  line_chart({{"pulses", c.pulse_s, c.frequency_hz, runs[n].style, false}},
                             from_zero("valve frequency", "t [s]", "ν [Hz]")));
  }
  return s.empty() ? ""
                   : "<h2>Along one path</h2>\n<p class=\"soft\">As in Figs. 6-2 and 6-3; the frequency is "
                     "one over the time between two pulses, which are "
                     "whole ticks.</p>\n<div class=\"row\">\n" +
                         s + "</div>\n";
}

}  // namespace

std::string shaded_relief(const HeightMap& h, double step_mm, const std::string& title) {
  constexpr double kSide = 420;
  const GridSpec& g = h.spec;
  Raster pixels(g.nx, g.ny);
  double top = -std::numeric_limits<double>::infinity();
  for (const double z : h.cells) top = std::isfinite(z) ? std::max(top, z) : top;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double z = h.at(i, j);
      if (!std::isfinite(z)) continue;
      const auto or_here = [&](double beside) { return std::isfinite(beside) ? beside : z; };
      const double east = or_here(h.at(std::min(i + 1, g.nx - 1), j)),
                   north = or_here(h.at(i, std::min(j + 1, g.ny - 1)));
      const double dx = (east - z) / g.pitch_x_mm, dy = (north - z) / g.pitch_y_mm;
      // Lambert's law under a light from the upper left: (-1, 1, 1.4).
      double light = (dx - dy + 1.4) / (std::sqrt(dx * dx + dy * dy + 1.0) * std::sqrt(3.96));
      light = std::clamp(0.25 + 0.75 * light, 0.15, 1.0);
      // Half a step aside: a flat top at a whole number of steps is not covered with its own noise.
      const auto band = [&](double height) { return std::floor(height / step_mm + 0.5); };
      const bool contour = step_mm > 0.0 && (band(z) != band(east) || band(z) != band(north));
      const double height = top > 0.0 ? std::clamp(z / top, 0.0, 1.0) : 0.0;
      const double shade = light * (contour ? 0.75 : 1.0);
      pixels.at(i, g.ny - 1 - j) = {std::uint8_t(shade * (150 + 80 * height)),
                                    std::uint8_t(shade * (175 + 65 * height)),
                                    std::uint8_t(shade * (195 + 55 * height)), 255};
    }
  const double width_mm = g.nx * g.pitch_x_mm, depth_mm = g.ny * g.pitch_y_mm,
               longer = std::max(width_mm, depth_mm);
  const double width = kSide * width_mm / longer, depth = kSide * depth_mm / longer;
  return svg_open(width, depth + 24, title) + svg_image(pixels, 0, 0, width, depth) +
         svg_text(width / 2, depth + 17, "middle", "name",
                  number(width_mm, 0) + " × " + number(depth_mm, 0) + " mm, " + number(top, 2) + " mm high") +
         "</svg>\n";
}

std::string ice_sections(const std::vector<NamedIce>& runs) {
  if (runs.empty()) return "";
  return error_maps(runs) + part(runs) + rms_by_height(runs) + curves(runs);
}

}  // namespace firn::report
