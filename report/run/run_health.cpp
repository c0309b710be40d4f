#include "report/run/run_health.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firn/deposition_report_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/run_end_t.hpp"
#include "lcmtypes/channels.h"
#include "report/draw/svg.h"
#include "report/run/report_page.h"
#include "runs/folder/verdict.h"

namespace firn::report {
namespace {

std::string marked(const std::string& text, bool good) {
  return "<span class=\"" + std::string(good ? "good" : "bad") + "\">" + escape_html(text) + "</span>";
}

std::string count_cell(std::int64_t n) { return n == 0 ? "0" : marked(std::to_string(n), false); }

std::string tolerance_cell(const RunData& r) {
  if (!r.result) return "not judged: the print has not ended";
  const std::string verdict = verdict_words(*r.result, r.words);
  if (verdict.empty()) return "not judged: the print can go on";
  const std::size_t colon = verdict.find(':');
  if (const std::optional<bool> within = within_tolerance(*r.result); within && colon != verdict.npos)
    return marked(verdict.substr(0, colon), *within) + escape_html(verdict.substr(colon));
  return escape_html(verdict);
}

std::string audit_cell(const std::string& verdict) {
  return verdict.empty() ? "not audited" : marked(verdict, verdict.starts_with("clean"));
}

}  // namespace

RunHealth health_of(const runs::RunMessages& messages) {
  RunHealth h;
  h.resumes = std::max(0, messages.incarnations() - 1);
  messages.each<run_end_t>(channels::kRunEnd.name, [&](const run_end_t& m) {
    const RunOutcome outcome = RunOutcome(m.outcome);
    h.stops += outcome != RunOutcome::kFinished && outcome != RunOutcome::kOutOfTolerance;
  });
  h.stops = std::max(h.stops, h.resumes);  // a run that was killed tells no end
  messages.each<deposition_report_t>(channels::kDepositionReport.name, [&](const deposition_report_t& m) {
    h.doubts += m.unknown_from < m.unknown_to;
  });
  messages.each<path_report_t>(channels::kPathReport.name, [&](const path_report_t& m) {
    h.doubts += Outcome(m.outcome) == Outcome::kUnknown;
  });
  for (const ChannelInfo& channel : channel_table())
    if (channel.name.starts_with("FAULT_"))
      messages.each<fault_t>(channel.name, [&](const fault_t& m) {
        h.warnings += Severity(m.severity) == Severity::kWarning;
        h.faults += Severity(m.severity) == Severity::kStop;
      });
  messages.each<layer_metrics_t>(channels::kLayerMetrics.name,
                                 [&](const layer_metrics_t& m) { h.rows_lost += m.rows_lost; });
  return h;
}

std::string health_table(const std::vector<ReportRun>& runs, const std::vector<std::string>& names) {
  std::string s =
      "<div class=\"scroll\"><table class=\"text "
      "whole\"><thead>\n<tr><th>run</th><th>tolerance</th><th>audit</th>"
      "<th>stops</th><th>resumes</th><th>doubts</th><th>faults</th><th>warnings</th>"
      "<th>lost rows</th></tr>\n</thead><tbody>\n";
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const RunHealth& h = runs[n].data.health;
    s += "<tr><td>" + escape_html(names[n]) + "</td><td>" + tolerance_cell(runs[n].data) + "</td><td>" +
         audit_cell(runs[n].audit) + "</td>";
    for (const std::int64_t count : {std::int64_t(h.stops), std::int64_t(h.resumes), std::int64_t(h.doubts),
                                     std::int64_t(h.faults), std::int64_t(h.warnings), h.rows_lost})
      s += "<td>" + count_cell(count) + "</td>";
    s += "</tr>\n";
  }
  return s + "</tbody></table></div>\n";
}

}  // namespace firn::report
