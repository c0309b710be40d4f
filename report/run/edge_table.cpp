#include "report/run/edge_table.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/grid/outline.h"
#include "report/draw/charts.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

bool is_length(const OutlineMetric& m) { return m.unit == "um"; }

std::string head_of(const OutlineMetric& m, const HeightUnit& unit) {
  return "<span title=\"" + escape_html(std::string(m.meaning)) + "\">" + std::string(m.words) + " [" +
         (is_length(m) ? unit.name : std::string(m.unit)) + "]</span>";
}

std::vector<std::string> values_of(const OutlineStats& o, const HeightUnit& unit) {
  std::vector<std::string> cells;
  for (const OutlineMetric& m : kOutlineMetrics) {
    const bool cut =
        o.cut && (m.value == &OutlineStats::size_error_x_mm || m.value == &OutlineStats::size_error_y_mm);
    cells.push_back((cut ? "≥ " : "") + number(o.*m.value * (is_length(m) ? unit.per_mm : m.factor)));
  }
  return cells;
}

}  // namespace

std::string edge_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  const bool in_mm = std::ranges::all_of(runs, [](const ReportRun& r) { return r.data.words.in_mm; });
  const HeightUnit unit = in_mm && !runs.empty() ? height_unit(runs.front().data.words) : HeightUnit{};
  std::vector<std::string> head{"run", "of"};
  for (const OutlineMetric& m : kOutlineMetrics) head.push_back(head_of(m, unit));
  const std::string amount = runs.empty() ? "droplets" : std::string(runs.front().data.words.amount);
  for (const std::string& what :
       {std::string("print time [s]"), std::string("passes"), std::string("stage runs"), amount})
    head.push_back(what);
  std::string rows;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const std::vector<LayerRow>& layers = runs[n].data.layers;
    if (layers.empty()) continue;
    const LayerRow& last = layers.back();
    const int passes = std::accumulate(layers.begin(), layers.end(), 0,
                                       [](int sum, const LayerRow& l) { return sum + l.passes; });
    int runs_of_stage = 0, slower = 0;
    for (const LayerRow& l : layers) {
      runs_of_stage += l.stage_runs;
      slower += l.slower_runs;
    }
    const auto add = [&](const char* of, const OutlineStats& o, bool costs) {
      std::vector<std::string> cells{escape_html(names[n]), of};
      for (std::string& v : values_of(o, unit)) cells.push_back(std::move(v));
      cells.push_back(costs ? number(last.end_s) : "");
      const auto of_stage = [&](int count) {  // a part of paths is counted in no passes
        return !costs ? "" : count ? std::to_string(count) : "–";
      };
      cells.push_back(of_stage(passes));
      cells.push_back(of_stage(runs_of_stage) +
                      (costs && slower ? " (" + std::to_string(slower) + " slower)" : ""));
      cells.push_back(costs ? std::to_string(last.drops_total) : "");
      rows += table_row(cells);
    };
    if (last.measured_outline) add("last map", *last.measured_outline, true);
    if (last.true_outline) add("true surface", *last.true_outline, !last.measured_outline);
  }
  if (rows.empty()) return "";
  return "<h2>Edge</h2>\n<div class=\"scroll\"><table><thead>\n" + table_row(head, "th") +
         "</thead><tbody>\n" + rows +
         "</tbody></table></div>\n<p class=\"soft\">Of the last map and, of a simulated run, of the true "
         "surface, both as means of the grid's cells, which cannot tell an edge below 0.8 pitches. Overspill "
         "lies beside the part and missing volume is below its height inside; an inset of the outline trades "
         "one for the other, misplaced is their sum. A pass is a run of the stage for each row of cells, or "
         "for each "
         "height in it at which droplets land; a slower run has droplets nearer than the jet follows.</p>\n";
}

}  // namespace firn::report
