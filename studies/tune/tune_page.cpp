#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "report/draw/charts.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "runtime/build_info.h"
#include "studies/tune/tune_answer.h"

namespace firn::tune {
namespace {

using report::escape_html;

constexpr double kUninformed = 0.8;  // of the prior's standard deviation

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string s = "<tr>";
  for (const std::string& c : cells) s += std::string("<") + tag + ">" + c + "</" + tag + ">";
  return s + "</tr>\n";
}

std::string table(const std::vector<std::string>& head, const std::string& body) {
  return "<div class=\"scroll\"><table class=\"text\"><thead>\n" + row(head, "th") + "</thead><tbody>\n" +
         body + "</tbody></table></div>\n";
}

std::string svg(const std::string& title, const std::string& inner) {
  return "<svg viewBox=\"0 0 440 330\" role=\"img\" style=\"max-width:540px\" "
         "xmlns=\"http://www.w3.org/2000/svg\"><title>" +
         escape_html(title) + "</title>" + inner + "</svg>\n";
}

std::string profile_chart(const TuneAnswer& a, const Profile& p) {
  report::Series s{"predicted, mean of the search's draws", {}, {}, 0, true, {}, {}};
  for (std::size_t n = 0; n < p.mean.size(); ++n) {
    if (!std::isfinite(p.mean[n])) continue;  // left out: no point, and no stretch of the axis
    s.x.push_back(p.value[n]);
    s.y.push_back(p.mean[n]);
    s.low.push_back(p.mean[n] - 1.96 * p.std_error[n]);
    s.high.push_back(p.mean[n] + 1.96 * p.std_error[n]);
  }
  report::ChartOptions o;
  o.title = a.goal + " along " + a.keys[p.key].key();
  o.x_name = a.keys[p.key].key();
  o.y_name = a.goal;
  if (p.flat_high > p.flat_low) {
    o.shaded = {{p.flat_low, p.flat_high}};
    o.shaded_label = "within 2 % of the optimum";
  }
  return svg(o.title, report::line_chart({s}, o));
}

// Draws of the laboratory, sorted by the old setting's goal.
std::string draws_chart(const TuneAnswer& a) {
  const Advice& d = *a.advice;
  std::vector<std::size_t> order(d.old_goal.size());
  for (std::size_t n = 0; n < order.size(); ++n) order[n] = n;
  std::ranges::stable_sort(order, {}, [&](std::size_t n) { return d.old_goal[n]; });
  report::Series before{"recorded setting", {}, {}, 0, true}, after{"best setting found", {}, {}, 1, true};
  for (std::size_t n = 0; n < order.size(); ++n) {
    before.x.push_back(double(n + 1));
    after.x.push_back(double(n + 1));
    before.y.push_back(d.old_goal[order[n]]);
    after.y.push_back(d.new_goal[order[n]]);
  }
  report::ChartOptions o;
  o.title = "The same laboratories with both settings";
  o.x_name = "draw of the laboratory, sorted";
  o.y_name = a.goal;
  o.whole_x = true;
  o.from_zero = true;
  return svg(o.title, report::line_chart({before, after}, o));
}

std::string parameters_table(const TuneAnswer& a) {
  std::string body;
  for (std::size_t p = 0; p < a.lab.lab->parameters.size(); ++p) {
    const LabParameter& q = a.lab.lab->parameters[p];
    const double m = a.lab.posterior.mean[p], d = a.lab.posterior.std(p);
    body += row({"<code>" + escape_html(std::string(q.name)) + "</code>",
                 fmt::format("{:.4g} {}", q.value(m), q.unit),
                 fmt::format("[{:.4g}, {:.4g}]", q.value(m - 1.96 * d), q.value(m + 1.96 * d)),
                 fmt::format("{:.0f} %", 100 * d), d > kUninformed ? "the logs tell nothing about it" : ""});
  }
  return table({"parameter", "estimate", "95 %", "of the uncertainty before", ""}, body);
}

std::string check_section(const TuneAnswer& a) {
  const FitCheck& c = a.lab.check;
  std::string s =
      "<h2>Does the estimated laboratory reproduce the runs?</h2>\n<p>" +
      fmt::format(
          "Largest deviation of a feature: {:.1f} standard deviations; {:.1f} are allowed. Mean square "
          "of all together: {:.1f}; {:.1f} is allowed.",
          c.largest, c.limit, c.joint, c.joint_limit) +
      "</p>\n";
  if (c.passed()) return s;
  std::string body;
  for (const auto& m : c.missed)
    body += row({escape_html(m.feature),
                 m.constant ? "the same in every simulated print" : fmt::format("{:+.1f}", m.deviation)});
  return s + table({"missed feature", "deviation [standard deviations]"}, body);
}

std::string advice_section(const TuneAnswer& a) {
  const Advice& d = *a.advice;
  std::string s = "<h2>Predicted curves</h2>\n";
  for (const Profile& p : d.profiles) s += profile_chart(a, p);
  s += draws_chart(a);
  if (d.rejected.empty()) return s;
  std::string body;
  for (const Rejected& r : d.rejected) body += row({escape_html(r.setting), escape_html(r.reason)});
  return s + "<h2>Settings left out</h2>\n" + table({"setting", "reason"}, body);
}

std::string next_section(const TuneAnswer& a) {
  if (a.next.empty()) return "";
  std::string body;
  for (const NextPrint& n : a.next)
    body += row({escape_html(n.name), fmt::format("{:.1f}", n.information),
                 n.narrows.empty() ? "" : fmt::format("{}: to {:.0f} %", n.narrows, 100 * n.narrows_to),
                 n.how.empty() ? "" : "<code>" + escape_html(n.how) + "</code>"});
  return "<h2>The next print that would tell most</h2>\n" +
         table({"print", "information [nats]", "uncertainty left", "settings"}, body);
}

}  // namespace

std::string tune_page(const TuneAnswer& a) {
  std::string runs;
  for (const RecordedRun& r : a.runs) runs += (runs.empty() ? "" : ", ") + r.name;
  std::string s =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><title>firn tune</title><style>" +
      std::string(report::kReportStyle) + "</style></head><body>\n<h1>Tuned from logs</h1>\n<p><b>" +
      escape_html(tune_line(a)) + "</b></p>\n<p class=\"soft\">" + escape_html(runs) +
      fmt::format(
          "; laboratory: {}; {} prints simulated; the promise is about the mean of {} prints with each "
          "setting; seed {}; firn {}",
          a.lab.lab->meaning, a.lab.prints + (a.advice ? a.advice->prints : 0), a.promised_prints, a.seed,
          build_commit()) +
      "</p>\n";
  if (a.advice) s += advice_section(a);
  s += check_section(a) + "<h2>The laboratory</h2>\n" + parameters_table(a) + next_section(a);
  return s + "</body></html>\n";
}

}  // namespace firn::tune
