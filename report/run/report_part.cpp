#include "report/run/report_part.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "report/draw/charts.h"
#include "report/draw/heat_map.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr double kPartUm = 1e3;       // per mm, of colour scales
constexpr double kPartShown = 0.995;  // of a run's cells decide about the scale of errors
constexpr double kOfMedian = 2.0;  // the scale in medians of the runs: one bad run must not blanch the others

const LayerRow* last_part_row(const RunData& r) { return r.layers.empty() ? nullptr : &r.layers.back(); }
HeightUnit unit_of(const std::vector<NamedRun>& runs) {
  return runs.empty() ? HeightUnit{} : height_unit(runs.front().data->words);
}
bool in_mm(const std::vector<NamedRun>& runs) { return !runs.empty() && runs.front().data->words.in_mm; }
std::string in_brackets(const std::string& what, const HeightUnit& unit) {
  return what + " [" + unit.name + "]";
}
bool has_map(const RunData& r) { return r.height.size() > 0; }

std::string part_figure(const std::string& caption, const std::string& body, const std::string& cls = "") {
  return "<figure" + (cls.empty() ? "" : " class=\"" + cls + "\"") + "><figcaption>" + caption +
         "</figcaption>\n" + body + "</figure>\n";
}

// The page has one legend for all charts.
ChartOptions chart(const std::string& title, const std::string& x_name, const std::string& y_name) {
  ChartOptions o{title, x_name, y_name};
  o.legend = false;
  return o;
}

HeightMap error_map(const RunData& r) {
  HeightMap e(r.height.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c)
    if (r.mask.cells[c]) e.cells[c] = r.height.cells[c] - r.target.cells[c];
  return e;
}

std::vector<double> sizes_um(const HeightMap& errors) {
  std::vector<double> sizes;
  for (const double e : errors.cells)
    if (std::isfinite(e)) sizes.push_back(std::abs(e) * kPartUm);
  return sizes;
}

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

using Figures = std::vector<std::string>;

std::string row_of(const Figures& figures, std::size_t from = 0) {
  std::string s;
  for (std::size_t n = from; n < figures.size(); ++n) s += figures[n];
  return s.empty() ? s : "<div class=\"row\">\n" + s + "</div>\n";
}

/// @param beside figures that share the maps' row
std::string part_error_maps(const std::vector<NamedRun>& runs, const Figures& beside) {
  double largest_um = 0.0;
  std::vector<double> usual_um;
  for (const NamedRun& r : runs) {
    if (!has_map(*r.data)) continue;
    const std::vector<double> sizes = sizes_um(error_map(*r.data));
    if (sizes.empty()) continue;
    largest_um = std::max(largest_um, *std::ranges::max_element(sizes));
    usual_um.push_back(quantile(sizes, kPartShown));
  }
  if (usual_um.empty()) return "";
  const double end_um = std::max(std::min(largest_um, kOfMedian * quantile(usual_um, 0.5)), 1e-3);
  const HeatScale scale{-end_um, end_um, ColorMap::kDiverging, in_mm(runs)};
  const HeightUnit unit = unit_of(runs);
  std::string s =
      "<h2>Error of the final surfaces</h2>\n<p class=\"soft\">Measured height minus target inside the part: "
      "orange is too high, blue too low.";
  if (end_um < largest_um)
    s += " Larger errors, up to " + number(largest_um / kPartUm * unit.per_mm) + " " + unit.name +
         ", have the colours of the scale's ends.";
  s += "</p>\n";
  Figures figures;
  for (const NamedRun& r : runs) {
    if (!has_map(*r.data)) continue;
    const LayerRow* l = last_part_row(*r.data);
    figures.push_back(part_figure("<b>" + escape_html(r.name) + "</b>" +
                                      (l ? ", layer " + std::to_string(l->layer) + ", RMS " +
                                               number(l->rms_mm * unit.per_mm) + " " + unit.name
                                         : ""),
                                  heat_map(error_map(*r.data), scale, "error of " + r.name, &r.data->mask),
                                  "map"));
  }
  figures.insert(figures.end(), beside.begin(), beside.end());
  return s + row_of(figures) + "<div class=\"bar\">" +
         color_bar(scale, in_brackets("height − target", unit)) + "</div>\n";
}

std::string surfaces(const std::vector<NamedRun>& runs) {
  HeatScale scale{std::numeric_limits<double>::infinity(), 0, ColorMap::kSequential, in_mm(runs)};
  for (const NamedRun& r : runs) {
    if (!has_map(*r.data)) continue;
    for (const double h : r.data->height.cells)
      if (std::isfinite(h)) {
        scale.low_um = std::min(scale.low_um, h * kPartUm);
        scale.high_um = std::max(scale.high_um, h * kPartUm);
      }
  }
  if (!(scale.low_um < scale.high_um)) return "";
  std::string s =
      "<h2>Final surfaces</h2>\n<p class=\"soft\">Measured height after the last layer; the line is the "
      "part's "
      "outline.</p>\n<div class=\"row\">\n";
  for (const NamedRun& r : runs)
    if (has_map(*r.data))
      s += part_figure("<b>" + escape_html(r.name) + "</b>",
                       heat_map(r.data->height, scale, "height of " + r.name, &r.data->mask), "map");
  return s + "</div><div class=\"bar\">" + color_bar(scale, in_brackets("height", unit_of(runs))) +
         "</div>\n";
}

// Bilinear between the cells' middles; the nearest ones beside the grid.
double height_at(const HeightMap& map, double x_mm, double y_mm) {
  const GridSpec& g = map.spec;
  const double u = std::clamp((x_mm - g.origin_x_mm) / g.pitch_x_mm, 0.0, g.nx - 1.0),
               v = std::clamp((y_mm - g.origin_y_mm) / g.pitch_y_mm, 0.0, g.ny - 1.0);
  const int i = std::clamp(int(u), 0, std::max(0, g.nx - 2)),
            j = std::clamp(int(v), 0, std::max(0, g.ny - 2)), right = std::min(i + 1, g.nx - 1),
            up = std::min(j + 1, g.ny - 1);
  const double a = u - i, b = v - j;
  return (1 - b) * ((1 - a) * map.at(i, j) + a * map.at(right, j)) +
         b * ((1 - a) * map.at(i, up) + a * map.at(right, up));
}

// Heights along the cut, else along x through the middle row.
Series section(const HeightMap& map, const std::string& label, int style,
               const std::optional<SurfaceCut>& cut, double per_mm) {
  Series s;
  s.label = label;
  s.style = style;
  if (cut) {
    const double step = 0.5 * std::min(map.spec.pitch_x_mm, map.spec.pitch_y_mm);
    const int steps = std::max(1, int((cut->to_mm - cut->from_mm) / step));
    for (int n = 0; n <= steps; ++n) {
      const double t = cut->from_mm + (cut->to_mm - cut->from_mm) * n / steps;
      s.x.push_back(t);
      s.y.push_back(height_at(map, cut->x_mm + t * cut->along_x, cut->y_mm + t * cut->along_y) * per_mm);
    }
    return s;
  }
  const int j = map.spec.ny / 2;
  for (int i = 0; i < map.spec.nx; ++i) {
    s.x.push_back(map.spec.x_mm(i));
    s.y.push_back(map.at(i, j) * per_mm);
  }
  return s;
}

constexpr double kWindow = 0.75;  // of the target's height: where the enlarged sections begin

/// The measured section first.
Figures sections(const std::vector<NamedRun>& runs) {
  std::vector<Series> measured, truths;
  double top = 0, target_top = 0;
  std::optional<SurfaceCut> cut;
  const HeightUnit unit = unit_of(runs);
  for (const NamedRun& run : runs) {
    const RunData& r = *run.data;
    if (!has_map(r)) continue;
    if (measured.empty()) {
      cut = r.cut;
      measured.push_back(section(r.target, "target", Series::kReference, cut, unit.per_mm));
      truths.push_back(measured.back());
    }
    measured.push_back(section(r.height, run.name, run.style, cut, unit.per_mm));
    if (r.truth) truths.push_back(section(*r.truth, run.name, run.style, cut, unit.per_mm));
    for (double h : measured.back().y) top = std::isfinite(h) ? std::max(top, h) : top;
    for (double h : r.target.cells) target_top = std::max(target_top, h * unit.per_mm);
  }
  if (measured.empty()) return {};
  const auto options = [&](const char* title, bool upper) {
    const std::string across =
        cut ? "across the line at (" + number(cut->x_mm, 1) + ", " + number(cut->y_mm, 1) + ") mm [mm]"
            : "x [mm], through the middle row";
    ChartOptions o = chart(title, across, in_brackets("height", unit));
    o.from_zero = !upper;
    if (upper) o.y_range = std::pair{kWindow * target_top, std::max(top, target_top) * 1.02};
    return o;
  };
  Figures figures{
      part_figure("Measured surface and target", line_chart(measured, options("cross-sections", false)))};
  // A line's section has no level top; a part that has not come so high would leave the window empty.
  const bool level = target_top > 0 && !cut && top > kWindow * target_top;
  if (level)
    figures.push_back(part_figure("Measured surface and target, the upper part enlarged",
                                  line_chart(measured, options("cross-sections, enlarged", true))));
  if (truths.size() > 1 && target_top > 0)
    figures.push_back(part_figure(
        level ? "True surface of the simulated world, enlarged" : "True surface of the simulated world",
        line_chart(truths, options("true cross-sections", level))));
  return figures;
}

std::string capital(std::string words) {
  if (!words.empty()) words[0] = char(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

template <class Value>
Series per_layer(const NamedRun& r, Value value) {
  Series s;
  s.label = r.name;
  s.style = r.style;
  s.marks = true;
  for (const LayerRow& l : r.data->layers) {
    if (l.layer == 0) continue;
    s.x.push_back(l.layer);
    s.y.push_back(value(l));
  }
  return s;
}

/// The RMS first, where heights were measured.
Figures by_layer(const std::vector<NamedRun>& runs) {
  std::vector<Series> rms, drops, std;
  const HeightUnit unit = unit_of(runs);
  for (const NamedRun& r : runs) {
    rms.push_back(per_layer(r, [&](const LayerRow& l) { return l.rms_mm * unit.per_mm; }));
    std.push_back(per_layer(r, [&](const LayerRow& l) { return l.std_mm * unit.per_mm; }));
    drops.push_back(per_layer(r, [](const LayerRow& l) { return double(l.drops); }));
  }
  const auto options = [](const std::string& title, const std::string& y_name, bool logarithmic) {
    ChartOptions o = chart(title, "layer", y_name);
    o.logarithmic = logarithmic;
    o.whole_x = true;
    o.from_zero = !logarithmic;
    return o;
  };
  const auto any_layer = [&](auto is) {
    return std::ranges::any_of(runs,
                               [&](const NamedRun& r) { return std::ranges::any_of(r.data->layers, is); });
  };
  const std::string amount(runs.empty() ? "" : runs.front().data->words.amount);
  const bool heights = any_layer([](const LayerRow& l) { return std::isfinite(l.rms_mm); }) ||
                       !any_layer([](const LayerRow&) { return true; });
  Figures figures;
  if (heights) {
    figures.push_back(part_figure(
        "RMS error about the final target",
        line_chart(rms, options("RMS per layer", in_brackets("RMS", unit) + ", logarithmic", true))));
    figures.push_back(
        part_figure("Roughness: standard deviation of the error",
                    line_chart(std, options("std per layer", in_brackets("std", unit), false))));
  }
  figures.push_back(
      part_figure(capital(amount), line_chart(drops, options(amount + " per layer", amount, false))));
  return figures;
}

std::string times(const std::vector<NamedRun>& runs) {
  using Spent = double LayerRow::*;
  std::vector<std::pair<std::string, Spent>> phases{{"deposit", &LayerRow::deposit_s},
                                                    {"cure", &LayerRow::cure_s},
                                                    {"scan", &LayerRow::scan_s},
                                                    {"decide", &LayerRow::decide_s},
                                                    {"pictures", &LayerRow::look_s}};
  std::erase_if(phases, [&](const auto& phase) {  // a lab without a lamp has none
    return std::ranges::none_of(runs, [&](const NamedRun& r) {
      return std::ranges::any_of(r.data->layers, [&](const LayerRow& l) { return l.*phase.second > 0; });
    });
  });
  double top = 0;
  std::vector<Bars> all;
  for (const NamedRun& r : runs) {
    Bars b;
    for (const auto& phase : phases) b.parts.push_back(phase.first);
    b.heights.resize(phases.size());
    for (const LayerRow& l : r.data->layers) {
      b.x.push_back(l.layer);
      double spent_s = 0.0;
      for (std::size_t p = 0; p < phases.size(); ++p) {
        b.heights[p].push_back(l.*phases[p].second);
        spent_s += b.heights[p].back();
      }
      top = std::max(top, spent_s);
    }
    all.push_back(std::move(b));
  }
  if (!(top > 0)) return "";
  std::vector<LegendEntry> entries;
  for (std::size_t p = 0; p < phases.size(); ++p)
    entries.push_back({phases[p].first, int(p), LegendEntry::Kind::kBar});
  std::string s =
      "<h2>Time per layer</h2>\n<p class=\"soft\">Node time by phase, all on one scale; layer 0 is the scan "
      "of the bare substrate.</p>\n<div class=\"still\">" +
      shared_legend(entries) + "</div>\n<div class=\"row\">\n";
  for (std::size_t n = 0; n < runs.size(); ++n) {
    if (all[n].x.empty()) continue;
    ChartOptions o = chart("time per layer of " + runs[n].name, "layer", "time [s]");
    o.whole_x = o.from_zero = true;
    s += part_figure("<b>" + escape_html(runs[n].name) + "</b>", bar_chart(all[n], top, o));
  }
  return s + "</div>\n";
}

// Each lab shows its own runs, in the order in which the labs first occur.
std::string lab_sections(const std::vector<NamedRun>& runs) {
  std::vector<const ReportLab*> labs;
  for (const NamedRun& r : runs)
    if (r.data->lab && r.data->lab->sections && std::ranges::find(labs, r.data->lab) == labs.end())
      labs.push_back(r.data->lab);
  std::string s;
  for (const ReportLab* lab : labs) {
    std::vector<NamedRun> own;
    for (const NamedRun& r : runs)
      if (r.data->lab == lab) own.push_back(r);
    s += lab->sections(own);
  }
  return s;
}

}  // namespace

std::string part_title(const PartIdentity& p) {
  return p.name + ", " + number(p.x_mm, 1) + " × " + number(p.y_mm, 1) + " × " + number(p.z_mm, 2) + " mm";
}

std::vector<PartRuns> parts_of(const std::vector<NamedRun>& runs) {
  std::vector<PartRuns> parts;
  std::vector<std::string> keys;
  for (const NamedRun& r : runs) {
    const PartIdentity& p = r.data->part;
    const auto at = std::ranges::find(keys, p.key);
    if (at != keys.end()) {
      parts[std::size_t(at - keys.begin())].runs.push_back(r);
      continue;
    }
    keys.push_back(p.key);
    parts.push_back({part_title(p), {r}});
  }
  return parts;
}

std::string part_sections(const std::vector<NamedRun>& runs) {
  std::vector<NamedInks> inks;
  for (const NamedRun& r : runs)
    if (r.data->inks) inks.push_back({r.name, &*r.data->inks});
  const Figures cuts = sections(runs), layers = by_layer(runs);
  // One run fills the page: its map, its section and its curve side by side.
  const bool one = runs.size() == 1 && !cuts.empty();
  const std::string maps = part_error_maps(runs, one ? Figures{cuts.front(), layers.front()} : Figures{});
  const std::size_t shown = one && !maps.empty() ? 1 : 0;
  const std::string cut_row = row_of(cuts, shown), layer_row = row_of(layers, shown);
  return maps + lab_sections(runs) + surfaces(runs) +
         (cut_row.empty() ? "" : "<h2>Cross-sections</h2>\n" + cut_row) + ink_sections(inks) +
         (layer_row.empty() ? "" : "<h2>Layer by layer</h2>\n" + layer_row) + times(runs);
}

}  // namespace firn::report
