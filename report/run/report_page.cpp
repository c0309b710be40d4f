#include "report/run/report_page.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/draw/charts.h"
#include "report/draw/heat_map.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_lab.h"

namespace firn::replay {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kUm = 1e3;  // per mm

const LayerRow* last(const RunData& r) { return r.layers.empty() ? nullptr : &r.layers.back(); }
bool has_map(const RunData& r) { return r.height.size() > 0; }

// The scheme, and the folder where two runs have the same scheme.
std::vector<std::string> labels(const std::vector<ReportRun>& runs) {
  std::vector<std::string> names;
  for (const ReportRun& r : runs) {
    const auto same = [&](const ReportRun& o) { return o.data.scheme == r.data.scheme; };
    const bool unique = std::ranges::count_if(runs, same) == 1 && !r.data.scheme.empty();
    names.push_back(unique ? r.data.scheme : r.data.scheme + " (" + r.data.folder + ")");
  }
  return names;
}

std::string figure(const std::string& caption, const std::string& body, const std::string& cls = "") {
  return "<figure" + (cls.empty() ? "" : " class=\"" + cls + "\"") + "><figcaption>" + caption +
         "</figcaption>\n" + body + "</figure>\n";
}

std::string table_row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string s = "<tr>";
  for (const std::string& c : cells) s += std::string("<") + tag + ">" + c + "</" + tag + ">";
  return s + "</tr>\n";
}

std::string value(double v, int decimals) { return std::isfinite(v) ? number(v, decimals) : "–"; }

// "≥" where the surface still stands at half the part's height at the border of its map.
std::string sizes(const OutlineStats& o) {
  return (o.cut ? "≥ " : "") + value(o.size_error_x_mm * kUm, 1) + ", " + value(o.size_error_y_mm * kUm, 1);
}

std::string result_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  double best = std::numeric_limits<double>::infinity();
  for (const ReportRun& r : runs)
    if (last(r.data)) best = std::min(best, last(r.data)->rms_mm);
  std::string s =
      "<div class=\"scroll\"><table><thead>\n" +
      table_row({"run", "layers", "droplets", "mean error [µm]", "RMS [µm]", "std [µm]", "min, max [µm]",
                 "volume [mm³]", "true RMS [µm]", "largest true error [µm]", "overspill [%]",
                 "first ring [µm]", "size error x, y [µm]", "print time [s]", "outcome", "replay"},
                "th") +
      "</thead><tbody>\n";
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const RunData& r = runs[n].data;
    const LayerRow* l = last(r);
    const LayerRow none;
    const auto um = [&](double mm) { return l ? number(mm * kUm, 2) : std::string("–"); };
    const LayerRow& v = l ? *l : none;
    const OutlineStats o = r.outline.value_or(OutlineStats{});
    const std::string& verdict = runs[n].verdict;
    const std::string outcome = r.outcome.empty() ? "not ended" : r.outcome;
    s += table_row(
        {"<span class=\"swatch\" style=\"background:var(--c" + std::to_string(n % 6) + ")\"></span>" +
             escape_html(names[n]),
         l ? std::to_string(v.layer) : "–", l ? std::to_string(v.drops_total) : "–", um(v.mean_error_mm),
         l && v.rms_mm == best && runs.size() > 1 ? "<span class=\"best\">" + um(v.rms_mm) + "</span>"
                                                  : um(v.rms_mm),
         um(v.std_mm), um(v.min_error_mm) + ", " + um(v.max_error_mm), l ? number(v.volume_mm3, 3) : "–",
         v.truth ? number(v.truth->rms_mm * kUm, 2) : "–",
         v.truth ? number(std::max(-v.truth->min_mm, v.truth->max_mm) * kUm, 2) : "–",
         value(o.overspill * 100, 2), value(o.first_ring_mm * kUm, 1), sizes(o), l ? number(v.end_s, 1) : "–",
         "<span title=\"" + escape_html(r.reason) + "\">" + escape_html(outcome) + "</span>",
         verdict.empty() ? "–"
                         : "<span class=\"" + std::string(verdict == "identical" ? "good" : "bad") + "\">" +
                               escape_html(verdict) + "</span>"});
  }
  return s +
         "</tbody></table></div>\n<p class=\"soft\">Errors are those of cells inside the part. Overspill is "
         "the "
         "volume beside the part over the part's, the first ring the mean height of the cells that share a "
         "side "
         "with it, the size error the width at half height less the target's: of the true surface if a "
         "simulated world told it, else of the last map, on the grid's cells; of ice, of part and scaffold "
         "together.</p>\n";
}

std::string summary(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::size_t best = runs.size(), worst = runs.size();
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const LayerRow* l = last(runs[n].data);
    if (!l) continue;
    if (best == runs.size() || l->rms_mm < last(runs[best].data)->rms_mm) best = n;
    if (worst == runs.size() || l->rms_mm > last(runs[worst].data)->rms_mm) worst = n;
  }
  if (best == runs.size()) return "<p>No run has a measured layer yet.</p>\n";
  const auto told = [&](std::size_t n) {
    return "<b>" + escape_html(names[n]) + "</b> " + number(last(runs[n].data)->rms_mm * kUm, 2) + " µm";
  };
  std::string s = "<p>Final RMS error about the target, measured: " + told(best);
  if (worst != best)
    s += "; the largest, " + told(worst) + ", is " +
         number(last(runs[worst].data)->rms_mm / last(runs[best].data)->rms_mm, 1) + " times as large";
  return s + ".</p>\n";
}

HeightMap error_map(const RunData& r) {
  HeightMap e(r.height.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c)
    if (r.mask.cells[c]) e.cells[c] = r.height.cells[c] - r.target.cells[c];
  return e;
}

std::string maps(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  HeatScale height{std::numeric_limits<double>::infinity(), 0, ColorMap::kSequential},
      error{0, 0, ColorMap::kDiverging};
  for (const ReportRun& r : runs) {
    if (!has_map(r.data)) continue;
    for (double h : r.data.height.cells)
      if (std::isfinite(h)) {
        height.low_um = std::min(height.low_um, h * kUm);
        height.high_um = std::max(height.high_um, h * kUm);
      }
    for (double e : error_map(r.data).cells)
      if (std::isfinite(e)) error.high_um = std::max(error.high_um, std::abs(e) * kUm);
  }
  if (!(height.low_um < height.high_um)) return "";
  error.high_um = std::max(error.high_um, 1e-3);
  error.low_um = -error.high_um;
  std::string tops =
      "<h2>Final surfaces</h2>\n<p class=\"soft\">Measured height after the last layer, all on one "
      "scale.</p>\n<div class=\"row\">\n";
  std::string errors =
      "<h2>Error of the final surfaces</h2>\n<p class=\"soft\">Measured height minus target inside the part: "
      "orange is too "
      "high, blue too low.</p>\n<div class=\"row\">\n";
  for (std::size_t n = 0; n < runs.size(); ++n) {
    if (!has_map(runs[n].data)) continue;
    const std::string caption = "<b>" + escape_html(names[n]) + "</b>, layer " +
                                (last(runs[n].data) ? std::to_string(last(runs[n].data)->layer) : "–");
    tops += figure(caption, heat_map(runs[n].data.height, height, "height of " + names[n]), "map");
    errors += figure(caption, heat_map(error_map(runs[n].data), error, "error of " + names[n]), "map");
  }
  return tops + "</div><div class=\"bar\">" + color_bar(height, "height [µm]") + "</div>\n" + errors +
         "</div><div class=\"bar\">" + color_bar(error, "height − target [µm]") + "</div>\n";
}

// Heights along x through the middle row.
Series section(const HeightMap& map, const std::string& label, int style) {
  Series s;
  s.label = label;
  s.style = style;
  const int j = map.spec.ny / 2;
  for (int i = 0; i < map.spec.nx; ++i) {
    s.x.push_back(map.spec.x_mm(i));
    s.y.push_back(map.at(i, j) * kUm);
  }
  return s;
}

std::string sections(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::vector<Series> measured, truths;
  double top = 0, target_top = 0;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const RunData& r = runs[n].data;
    if (!has_map(r)) continue;
    if (measured.empty()) {
      measured.push_back(section(r.target, "target", Series::kReference));
      truths.push_back(measured.back());
    }
    measured.push_back(section(r.height, names[n], int(n)));
    if (r.truth) truths.push_back(section(*r.truth, names[n] + ", true", int(n)));
    for (double h : measured.back().y) top = std::isfinite(h) ? std::max(top, h) : top;
    for (double h : r.target.cells) target_top = std::max(target_top, h * kUm);
  }
  if (measured.empty()) return "";
  const std::string x = "x [mm], through the middle row";
  std::string s = "<h2>Cross-sections</h2>\n<div class=\"row\">\n" +
                  figure("Measured surface and target",
                         line_chart(measured, {"cross-sections", x, "height [µm]", false, false, true, {}}));
  if (target_top > 0)
    s += figure("The same, the upper part enlarged",
                line_chart(measured, {"cross-sections, enlarged", x, "height [µm]", false, false, false,
                                      std::pair{0.75 * target_top, std::max(top, target_top) * 1.02}}));
  if (truths.size() > 1 && target_top > 0)
    s += figure("True surface of the simulated world, enlarged",
                line_chart(truths, {"true cross-sections", x, "height [µm]", false, false, false,
                                    std::pair{0.75 * target_top, std::max(top, target_top) * 1.02}}));
  return s + "</div>\n";
}

template <class Value>
Series per_layer(const RunData& r, const std::string& label, int style, Value value) {
  Series s;
  s.label = label;
  s.style = style;
  s.marks = true;
  for (const LayerRow& l : r.layers) {
    if (l.layer == 0) continue;
    s.x.push_back(l.layer);
    s.y.push_back(value(l));
  }
  return s;
}

std::string by_layer(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::vector<Series> rms, drops, std_um;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const RunData& r = runs[n].data;
    rms.push_back(per_layer(r, names[n], int(n), [](const LayerRow& l) { return l.rms_mm * kUm; }));
    std_um.push_back(per_layer(r, names[n], int(n), [](const LayerRow& l) { return l.std_mm * kUm; }));
    drops.push_back(per_layer(r, names[n], int(n), [](const LayerRow& l) { return double(l.drops); }));
  }
  return "<h2>Layer by layer</h2>\n<div class=\"row\">\n" +
         figure("RMS error about the final target",
                line_chart(rms, {"RMS per layer", "layer", "RMS [µm], logarithmic", true, true, false, {}})) +
         figure("Roughness: standard deviation of the error",
                line_chart(std_um, {"std per layer", "layer", "std [µm]", false, true, true, {}})) +
         figure("Droplets",
                line_chart(drops, {"droplets per layer", "layer", "droplets", false, true, true, {}})) +
         "</div>\n";
}

std::string times(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  double top = 0;
  std::vector<Bars> all;
  for (const ReportRun& r : runs) {
    Bars b;
    b.parts = {"deposit", "cure", "scan", "decide"};
    b.heights.resize(4);
    for (const LayerRow& l : r.data.layers) {
      b.x.push_back(l.layer);
      const double phases[] = {l.deposit_s, l.cure_s, l.scan_s, l.decide_s};
      for (std::size_t p = 0; p < 4; ++p) b.heights[p].push_back(phases[p]);
      top = std::max(top, l.deposit_s + l.cure_s + l.scan_s + l.decide_s);
    }
    all.push_back(std::move(b));
  }
  if (!(top > 0)) return "";
  std::string s =
      "<h2>Time per layer</h2>\n<p class=\"soft\">Node time by phase, all on one scale; layer 0 is the scan "
      "of the bare "
      "substrate.</p>\n<div class=\"row\">\n";
  for (std::size_t n = 0; n < runs.size(); ++n)
    if (!all[n].x.empty())
      s += figure("<b>" + escape_html(names[n]) + "</b>",
                  bar_chart(all[n], top,
                            {"time per layer of " + names[n], "layer", "time [s]", false, true, true, {}}));
  return s + "</div>\n";
}

std::string differing(const std::vector<DifferingParameter>& parameters,
                      const std::vector<std::string>& names) {
  if (names.size() < 2) return "";
  std::string s = "<h2>Settings that differ</h2>\n";
  if (parameters.empty()) return s + "<p>None: all runs were configured alike.</p>\n";
  std::vector<std::string> head{"setting"};
  for (const std::string& n : names) head.push_back(escape_html(n));
  s += "<div class=\"scroll\"><table><thead>\n" + table_row(head, "th") + "</thead><tbody>\n";
  for (const DifferingParameter& p : parameters) {
    std::vector<std::string> cells{"<code>" + escape_html(p.key) + "</code>" +
                                   (p.unit.empty() ? "" : " [" + escape_html(p.unit) + "]")};
    for (const std::string& v : p.values) cells.push_back(escape_html(v));
    s += table_row(cells);
  }
  return s + "</tbody></table></div>\n";
}

std::string provenance(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::vector<std::string> head{""};
  for (const std::string& n : names) head.push_back(escape_html(n));
  std::string s = "<h2>Provenance</h2>\n<div class=\"scroll\"><table class=\"text\"><thead>\n" +
                  table_row(head, "th") + "</thead><tbody>\n";
  std::vector<std::string> cells{"run folder"};
  for (const ReportRun& r : runs) cells.push_back("<code>" + escape_html(r.data.folder) + "</code>");
  s += table_row(cells);
  for (std::size_t k = 0; k < runs.front().data.provenance.size(); ++k) {
    cells = {escape_html(runs.front().data.provenance[k].first)};
    for (const ReportRun& r : runs) cells.push_back(escape_html(r.data.provenance[k].second));
    s += table_row(cells);
  }
  cells = {"why it ended"};
  for (const ReportRun& r : runs) cells.push_back(escape_html(r.data.reason));
  return s + table_row(cells) + "</tbody></table></div>\n";
}

// Each lab shows its own runs, in the order in which the labs first occur.
std::string lab_sections(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::vector<const ReportLab*> labs;
  for (const ReportRun& r : runs)
    if (r.data.lab && r.data.lab->sections && std::ranges::find(labs, r.data.lab) == labs.end())
      labs.push_back(r.data.lab);
  std::string s;
  for (const ReportLab* lab : labs) {
    std::vector<NamedRun> own;
    for (std::size_t n = 0; n < runs.size(); ++n)
      if (runs[n].data.lab == lab) own.push_back({names[n], &runs[n].data});
    s += lab->sections(own);
  }
  return s;
}

}  // namespace

std::string report_page(const std::vector<ReportRun>& runs,
                        const std::vector<DifferingParameter>& parameters) {
  std::string s =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Firn: print "
      "report</title>\n<style>";
  s += kReportStyle;
  s += "</style></head><body>\n<h1>Print report</h1>\n";
  if (runs.empty()) return s + "<p>No runs.</p></body></html>\n";
  const std::vector<std::string> names = labels(runs);
  std::vector<NamedInks> inks;
  for (std::size_t n = 0; n < runs.size(); ++n)
    if (runs[n].data.inks) inks.push_back({names[n], &*runs[n].data.inks});
  s += health_table(runs, names) + summary(runs, names) + result_table(runs, names) +
       lab_sections(runs, names) + maps(runs, names) + sections(runs, names) + ink_sections(inks) +
       by_layer(runs, names) + times(runs, names) + differing(parameters, names) + provenance(runs, names);
  return s + "</body></html>\n";
}

}  // namespace firn::replay
