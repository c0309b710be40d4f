#include "report/run/report_page.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "report/draw/charts.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/report_part.h"

namespace firn::replay {
namespace {

constexpr double kUm = 1e3;        // per mm
constexpr int kFirstOfParts = 10;  // column of the result table

const LayerRow* last(const RunData& r) { return r.layers.empty() ? nullptr : &r.layers.back(); }

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

bool better(const NamedRun& a, const NamedRun& b) { return last(*a.data)->rms_mm < last(*b.data)->rms_mm; }

// The runs of a part that have measured a layer's heights.
std::vector<NamedRun> measured(const PartRuns& part) {
  std::vector<NamedRun> runs = part.runs;
  std::erase_if(runs, [](const NamedRun& r) { return !last(*r.data) || std::isnan(last(*r.data)->rms_mm); });
  return runs;
}

// The smallest RMS of each part, where there is something to compare.
std::set<const RunData*> best_of(const std::vector<PartRuns>& parts) {
  std::set<const RunData*> best;
  for (const PartRuns& part : parts) {
    const std::vector<NamedRun> runs = measured(part);
    if (part.runs.size() < 2 || runs.empty()) continue;
    const double rms_mm = last(*std::ranges::min_element(runs, better)->data)->rms_mm;
    for (const NamedRun& r : runs)
      if (last(*r.data)->rms_mm == rms_mm) best.insert(r.data);
  }
  return best;
}

std::string result_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names,
                         const std::vector<PartRuns>& parts) {
  const std::set<const RunData*> best = best_of(parts);
  const bool lines = std::ranges::all_of(runs, [](const ReportRun& r) { return r.data.lab == &kLineReport; });
  // Columns of parts that have an area; lines have their own table.
  const auto without_parts = [&](std::vector<std::string> cells) {
    if (lines) cells.erase(cells.begin() + kFirstOfParts, cells.begin() + kFirstOfParts + 3);
    return cells;
  };
  std::string s =
      "<div class=\"scroll\"><table><thead>\n" +
      table_row(without_parts({"run", "layers", lines ? "switches" : "droplets", "mean error [µm]",
                               "RMS [µm]", "std [µm]", "min, max [µm]", "volume [mm³]", "true RMS [µm]",
                               "largest true error [µm]", "overspill [%]", "first ring [µm]",
                               "size error x, y [µm]", "print time [s]", "outcome", "replay"}),
                "th") +
      "</thead><tbody>\n";
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const RunData& r = runs[n].data;
    const LayerRow* l = last(r);
    const LayerRow none;
    const auto um = [&](double mm) { return l ? value(mm * kUm, 2) : std::string("–"); };
    const LayerRow& v = l ? *l : none;
    const OutlineStats o = r.outline.value_or(OutlineStats{});
    const std::string& verdict = runs[n].verdict;
    const std::string outcome = r.outcome.empty() ? "not ended" : r.outcome;
    s += table_row(without_parts(
        {legend_sample({names[n], int(n)}) + escape_html(names[n]), l ? std::to_string(v.layer) : "–",
         l ? std::to_string(v.drops_total) : "–", um(v.mean_error_mm),
         best.contains(&r) ? "<span class=\"best\">" + um(v.rms_mm) + "</span>" : um(v.rms_mm), um(v.std_mm),
         um(v.min_error_mm) + ", " + um(v.max_error_mm), l ? value(v.volume_mm3, 3) : "–",
         v.truth ? number(v.truth->rms_mm * kUm, 2) : "–",
         v.truth ? number(std::max(-v.truth->min_mm, v.truth->max_mm) * kUm, 2) : "–",
         value(o.overspill * 100, 2), value(o.first_ring_mm * kUm, 1), sizes(o), l ? number(v.end_s, 1) : "–",
         "<span title=\"" + escape_html(r.reason) + "\">" + escape_html(outcome) + "</span>",
         verdict.empty() ? "–"
                         : "<span class=\"" + std::string(verdict == "identical" ? "good" : "bad") + "\">" +
                               escape_html(verdict) + "</span>"}));
  }
  if (lines)
    return s +
           "</tbody></table></div>\n<p class=\"soft\">Errors are those of cells within half a width of the "
           "lines' middles. The profiler's spot "
           "sees a line lower than it is; the true errors are without that.</p>\n";
  return s +
         "</tbody></table></div>\n<p class=\"soft\">Errors are those of cells inside the part. Overspill is "
         "the "
         "volume beside the part over the part's, the first ring the mean height of the cells that share a "
         "side "
         "with it, the size error the width at half height less the target's: of the true surface if a "
         "simulated world told it, else of the last map, on the grid's cells; of ice, of part and scaffold "
         "together.</p>\n";
}

// A sentence a part.
std::string summary(const std::vector<PartRuns>& parts) {
  std::string s;
  for (const PartRuns& part : parts) {
    const std::vector<NamedRun> runs = measured(part);
    if (runs.empty()) continue;
    const auto [best, worst] = std::ranges::minmax_element(runs, better);
    const auto told = [](const NamedRun& r) {
      return "<b>" + escape_html(r.name) + "</b> " + number(last(*r.data)->rms_mm * kUm, 2) + " µm";
    };
    s += "<p>" + (parts.size() > 1 ? escape_html(part.title) + ": final" : std::string("Final")) +
         " RMS error about the target, measured: " + told(*best);
    if (best != worst)
      s += "; the largest, " + told(*worst) + ", is " +
           number(last(*worst->data)->rms_mm / last(*best->data)->rms_mm, 1) + " times as large";
    s += ".</p>\n";
  }
  return s.empty() ? "<p>No run has measured a layer's heights.</p>\n" : s;
}

std::string legend(const std::vector<std::string>& names) {
  std::vector<LegendEntry> entries;
  for (std::size_t n = 0; n < names.size(); ++n) entries.push_back({names[n], int(n)});
  entries.push_back({"target", Series::kReference});
  return shared_legend(entries);
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
  std::vector<NamedRun> all;
  for (std::size_t n = 0; n < runs.size(); ++n) all.push_back({names[n], &runs[n].data, int(n)});
  const std::vector<PartRuns> parts = parts_of(all);
  s += health_table(runs, names) + summary(parts) + result_table(runs, names, parts) + legend(names);
  for (const PartRuns& part : parts) {
    if (parts.size() > 1) s += "<h2 class=\"part\">" + escape_html(part.title) + "</h2>\n";
    s += part_sections(part.runs);
  }
  s += differing(parameters, names) + provenance(runs, names);
  return s + "</body></html>\n";
}

}  // namespace firn::replay
