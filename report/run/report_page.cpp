#include "report/run/report_page.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/options/for_people.h"
#include "report/draw/charts.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/edge_table.h"
#include "report/run/meta_table.h"
#include "report/run/report_part.h"
#include "report/run/settings_table.h"

namespace firn::report {
namespace {

constexpr double kMmPerUm = 1e-3;
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

// "≥" where the surface still stands at half the part's height at the border of its map.
std::string sizes(const OutlineStats& o, const HeightUnit& unit) {
  return (o.cut ? "≥ " : "") + number(o.size_error_x_mm * unit.per_mm) + ", " +
         number(o.size_error_y_mm * unit.per_mm);
}

// The outline of the last map, as result.json and the terminal tell it; a file of an older program lacks it.
OutlineStats measured_outline(const RunData& r) {
  if (const LayerRow* l = last(r); l && l->measured_outline) return *l->measured_outline;
  return r.result && r.result->outline ? *r.result->outline : OutlineStats{};
}

OutlineStats true_outline(const RunData& r) {
  const LayerRow* l = last(r);
  return l && l->true_outline ? *l->true_outline : OutlineStats{};
}

bool is_told(const OutlineStats& o) {
  return std::ranges::any_of(kOutlineMetrics,
                             [&](const OutlineMetric& m) { return std::isfinite(o.*m.value); });
}

// That of the runs' labs; um where they differ.
HeightUnit unit_of_all(const std::vector<ReportRun>& runs) {
  const bool in_mm = std::ranges::all_of(runs, [](const ReportRun& r) { return r.data.words.in_mm; });
  return in_mm ? height_unit(runs.front().data.words) : HeightUnit{};
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

// That of the first run: a report of several labs has one table all the same.
std::string amount_name(const std::vector<ReportRun>& runs) {
  return std::string(runs.front().data.words.amount);
}

std::string result_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names,
                         const std::vector<PartRuns>& parts) {
  const std::set<const RunData*> best = best_of(parts);
  const bool lines = std::ranges::all_of(runs, [](const ReportRun& r) { return r.data.lab == &kLineReport; });
  // Columns of parts that have an area; lines have their own table.
  const HeightUnit unit = unit_of_all(runs);
  // All runs are shown by the surface that the print was judged by. Along paths no map tells the outline.
  const auto told_by = [&](auto outline) {
    return std::ranges::any_of(runs, [&](const ReportRun& r) { return is_told(outline(r.data)); });
  };
  const bool of_truth = !told_by(measured_outline) && told_by(true_outline);
  const auto of = [&](const char* what) { return std::string(what) + " [" + unit.name + "]"; };
  const auto edge = [&](std::string_view name, const std::string& words = "") {
    const OutlineMetric& m = outline_metric(name);
    return (of_truth ? "true " : "") + (words.empty() ? std::string(m.words) : words) + " [" +
           (m.unit == "um" ? unit.name : std::string(m.unit)) + "]";
  };
  const auto without_parts = [&](std::vector<std::string> cells) {
    if (lines) cells.erase(cells.begin() + kFirstOfParts, cells.begin() + kFirstOfParts + 3);
    return cells;
  };
  std::string s =
      "<div class=\"scroll\"><table><thead>\n" +
      table_row(without_parts({"run", "layers", amount_name(runs), of("mean error"), of("RMS"),
                               of("RMS inside, rim"), of("min, max"), "volume [mm³]", of("true RMS"),
                               of("largest true error"), edge("overspill_pct"), edge("first_ring_um"),
                               edge("size_x_um", "size error x, y"), "print time [s]", "outcome", "replay"}),
                "th") +
      "</thead><tbody>\n";
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const RunData& r = runs[n].data;
    const LayerRow* l = last(r);
    const LayerRow none;
    const auto height = [&](double mm) { return l ? number(mm * unit.per_mm) : std::string("–"); };
    const LayerRow& v = l ? *l : none;
    const OutlineStats o = of_truth ? true_outline(r) : measured_outline(r);
    const OutlineMetric& overspill = outline_metric("overspill_pct");
    const std::string& verdict = runs[n].verdict;
    runs::RunResult result = r.result.value_or(runs::RunResult{});
    if (!r.result) result.outcome = "not ended";
    const runs::MapError error = result.error.value_or(runs::MapError{});
    const auto told = [&](double um) {
      return um > 0.0 ? number(um * kMmPerUm * unit.per_mm) : std::string("–");
    };
    s += table_row(without_parts(
        {legend_sample({names[n], int(n)}) + escape_html(names[n]), l ? std::to_string(v.layer) : "–",
         l ? std::to_string(v.drops_total) : "–", height(v.mean_error_mm),
         best.contains(&r) ? "<span class=\"best\">" + height(v.rms_mm) + "</span>" : height(v.rms_mm),
         told(error.rms_inside_um) + ", " + told(error.rms_rim_um),
         height(v.min_error_mm) + ", " + height(v.max_error_mm), l ? number(v.volume_mm3) : "–",
         v.truth ? height(v.truth->rms_mm) : "–",
         v.truth ? height(std::max(-v.truth->min_mm, v.truth->max_mm)) : "–",
         number(o.*overspill.value * overspill.factor), number(o.first_ring_mm * unit.per_mm), sizes(o, unit),
         l ? number(v.end_s) : "–",
         "<span title=\"" + escape_html(for_people(result.reason)) + "\">" + escape_html(result.outcome) +
             "</span>",
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
         "</tbody></table></div>\n<p class=\"soft\">Errors are those of cells inside the part. Columns named "
         "<i>true</i> are of the surface that a simulated world told, all others of the last map. Overspill "
         "is the volume beside the part over the part's; the first ring the mean height of the cells that "
         "share a side with it, the size error the width at half height less the target's, on the grid's "
         "cells; of ice, of part and scaffold together.</p>\n";
}

// A sentence a part.
std::string summary(const std::vector<PartRuns>& parts) {
  std::string s;
  for (const PartRuns& part : parts) {
    const std::vector<NamedRun> runs = measured(part);
    if (runs.empty()) continue;
    const auto [best, worst] = std::ranges::minmax_element(runs, better);
    const auto told = [](const NamedRun& r) {
      const HeightUnit unit = height_unit(r.data->words);
      return "<b>" + escape_html(r.name) + "</b> " + number(last(*r.data)->rms_mm * unit.per_mm) + " " +
             unit.name;
    };
    s += "<p>" + (parts.size() > 1 ? escape_html(part.title) + ": final" : std::string("Final")) +
         " RMS error about the target, measured: " + told(*best);
    if (last(*best->data)->rms_mm < last(*worst->data)->rms_mm)
      s += "; the largest, " + told(*worst) + ", is " +
           number(last(*worst->data)->rms_mm / last(*best->data)->rms_mm) + " times as large";
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
  return s + settings_table(parameters, names);
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
  for (const ReportRun& r : runs)
    cells.push_back(escape_html(r.data.result ? for_people(r.data.result->reason) : ""));
  return s + table_row(cells) + "</tbody></table></div>\n";
}

// Part and size; of several parts the number of runs.
std::string title_of(const std::vector<ReportRun>& runs) {
  if (runs.empty()) return "print report";
  const auto title = [](const ReportRun& r) { return escape_html(part_title(r.data.part)); };
  const std::string first = title(runs.front());
  if (std::ranges::all_of(runs, [&](const ReportRun& r) { return title(r) == first; })) return first;
  return std::to_string(runs.size()) + " prints";
}

std::string under_title(const std::vector<ReportRun>& runs) {
  if (runs.size() != 1)
    return "<p class=\"soft\">" + std::to_string(runs.size()) + " runs beside each other</p>\n";
  const RunData& r = runs.front().data;
  const auto started =
      std::ranges::find(r.provenance, "started", &std::pair<std::string, std::string>::first);
  return "<p class=\"soft\">" + escape_html(r.scheme) +
         (started == r.provenance.end() ? "" : ", " + escape_html(started->second)) + "</p>\n";
}

}  // namespace

std::string report_page(const std::vector<ReportRun>& runs,
                        const std::vector<DifferingParameter>& parameters) {
  std::string s =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Firn: " +
      title_of(runs) + "</title>\n<style>" + kReportStyle + "</style></head><body>\n<h1>" + title_of(runs) +
      "</h1>\n";
  if (runs.empty()) return s + "<p>No runs.</p></body></html>\n";
  s += under_title(runs);
  const std::vector<std::string> names = labels(runs);
  std::vector<NamedRun> all;
  for (std::size_t n = 0; n < runs.size(); ++n) all.push_back({names[n], &runs[n].data, int(n)});
  const std::vector<PartRuns> parts = parts_of(all);
  s += health_table(runs, names) + summary(parts) + result_table(runs, names, parts) + legend(names) +
       meta_table(runs, names) + edge_table(runs, names);
  for (const PartRuns& part : parts) {
    if (parts.size() > 1) s += "<h2 class=\"part\">" + escape_html(part.title) + "</h2>\n";
    s += part_sections(part.runs);
  }
  s += differing(parameters, names) + provenance(runs, names);
  return s + "</body></html>\n";
}

}  // namespace firn::report
