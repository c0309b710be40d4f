#include "report/study/study_page.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/options/for_people.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "report/run/settings_table.h"
#include "report/study/settings_plot.h"
#include "report/study/study_answer.h"
#include "report/study/study_plots.h"
#include "report/study/study_profile.h"
#include "report/study/study_ratios.h"

namespace firn::report {
namespace {

constexpr std::size_t kManyArms = 6;  // beyond, only the pairs with the best arm and the baseline are drawn

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string s = "<tr>";
  for (const std::string& c : cells) s += std::string("<") + tag + ">" + c + "</" + tag + ">";
  return s + "</tr>\n";
}

std::string table_of(const std::vector<std::string>& head, const std::string& body, const char* cls = "") {
  return "<div class=\"scroll\"><table class=\"" + std::string(cls) + "\"><thead>\n" + row(head, "th") +
         "</thead><tbody>\n" + body + "</tbody></table></div>\n";
}

std::string with_interval(double value, const statistics::Interval& i, int decimals) {
  return number(value, decimals) + " <span class=\"soft\">[" + number(i.low, decimals) + ", " +
         number(i.high, decimals) + "]</span>";
}

std::string metric_head(const StudyMetric& m) {
  return "<span title=\"" + escape_html(m.meaning) + "\">" + escape_html(m.name) +
         (m.unit.empty() ? "" : " [" + escape_html(m.unit) + "]") + "</span>";
}

std::string part_name(const StudyTable& t, int part) {
  return part == kAllParts ? "all parts" : t.parts[std::size_t(part)];
}

std::string arms_table(const StudyTable& t, const StudyAnalysis& a, int part) {
  std::vector<std::string> head{"scheme", t.trial + "s"};
  for (const StudyMetric& m : t.metrics) head.push_back(metric_head(m));
  std::string body;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    std::vector<std::string> cells{"<span class=\"swatch\" style=\"background:var(--c" +
                                   std::to_string(arm % 6) + ")\"></span>" + escape_html(t.arms[arm])};
    for (const ArmSummary& s : a.summaries) {
      if (s.arm != arm || s.part != part) continue;
      if (cells.size() == 1)
        cells.push_back(std::to_string(s.seeds) +
                        (failures_text(t, a, arm).empty()
                             ? ""
                             : " <span class=\"bad\">(" + failures_text(t, a, arm) + ")</span>"));
      const std::string text = with_interval(s.mean, s.interval, t.metrics[s.metric].decimals);
      const bool best = s.metric == 0 && part == kAllParts && !a.ranking.empty() && a.ranking[0] == arm;
      cells.push_back(best ? "<span class=\"best\">" + text + "</span>" : text);
    }
    body += row(cells);
  }
  return table_of(head, body);
}

std::string metric_meanings(const StudyTable& t) {
  std::string s;
  for (const StudyMetric& m : t.metrics)
    s += (s.empty() ? "<code>" : "; <code>") + escape_html(m.name) + "</code> " + escape_html(m.meaning);
  return "<p class=\"soft\">" + s + ".</p>\n";
}

std::string pairs_table(const StudyTable& t, const std::vector<const ArmComparison*>& pairs) {
  std::string body;
  for (const ArmComparison* c : pairs) {
    if (c->values.pairs == 0 && (c->metric != 0 || !c->any_failed()))
      continue;  // one of the two does not measure it
    const auto& v = c->values;
    const int decimals = t.metrics[c->metric].decimals;
    body +=
        row({escape_html(t.arms[c->a]) + " – " + escape_html(t.arms[c->b]),
             std::to_string(v.pairs) +
                 (c->any_failed() ? " <span class=\"bad\">(failed prints " + std::to_string(c->failed_a) +
                                        " : " + std::to_string(c->failed_b) + ", Holm p " +
                                        escape_html(p_text(c->failures_holm_p)) + ")</span>"
                                  : ""),
             number(v.mean_a, decimals), number(v.mean_b, decimals),
             with_interval(v.difference, v.interval, decimals), number(v.effect, 2),
             number(100.0 * v.a_below_b, 0) + " %",
             (v.p < 0.001 ? "&lt; 0.001" : number(v.p, 3)) +
                 std::string(c->at_smallest_p() ? " <span class=\"soft\">(smallest possible)</span>" : ""),
             c->holm_p <= kAlpha
                 ? "<span class=\"good\">" +
                       std::string(c->holm_p < 0.001 ? "&lt; 0.001" : number(c->holm_p, 3)) + "</span>"
                 : number(c->holm_p, 3),
             c->told_apart() ? escape_html(t.arms[c->better()]) + " is better" : "not distinguishable"});
  }
  return table_of({"pair", t.trial + "s", "first", "second", "difference [95 % interval]",
                   "effect d<sub>z</sub>", "first smaller", "p", "Holm p", ""},
                  body);
}

std::vector<const ArmComparison*> family(const StudyAnalysis& a, std::size_t metric, int part) {
  std::vector<const ArmComparison*> out;
  for (const ArmComparison& c : a.comparisons)
    if (c.metric == metric && c.part == part) out.push_back(&c);
  return out;
}

std::string plots(const StudyTable& t, const StudyAnalysis& a, const std::string& nature) {
  std::string s =
      "<h2>Every print</h2>\n<p class=\"soft\">A dot is a print; the bar is the mean with its 95 % "
      "interval.</p>\n<div class=\"row\">\n";
  for (std::size_t p = 0; p < t.parts.size(); ++p)
    s += "<figure><figcaption><b>" + escape_html(t.parts[p]) + "</b></figcaption>\n" +
         distribution_plot(t, a, int(p), 0) + "</figure>\n";
  s += "</div>\n";
  std::vector<const ArmComparison*> drawn = family(a, 0, kAllParts);
  if (t.arms.size() > kManyArms && !a.ranking.empty())
    std::erase_if(drawn, [&](const ArmComparison* c) {
      const auto named = [&](std::size_t arm) { return arm == a.ranking[0] || t.arms[arm] == t.baseline; };
      return !named(c->a) && !named(c->b);
    });
  if (drawn.empty()) return s;
  return s + "<h2>Differences, pair by pair</h2>\n<p class=\"soft\">" +
         (t.trial == "seed" ? "Both prints of a pair met the same nature: the same seed" +
                                  (nature.empty() ? "" : ", and " + nature) + "."
                            : "A pair is the n-th " + t.trial + " of two schemes, in the order given.") +
         " Blue: told apart at 5 % after "
         "Holm's adjustment; grey: not "
         "distinguishable.</p>\n<figure class=\"forest\">" +
         forest_plot(t, drawn) + "</figure>\n";
}

// For a study that also measures the duration of prints.
std::string trade_off(const StudyTable& t, const StudyAnalysis& a) {
  for (std::size_t m = 1; m < t.metrics.size(); ++m) {
    if (t.metrics[m].name != "time_h") continue;
    const std::string plot = trade_off_plot(t, a, m, 0);
    return plot.empty() ? plot
                        : "<h2>Accuracy against time</h2>\n<p class=\"soft\">A mark for each scheme: means "
                          "over parts and " +
                              t.trial + "s, with 95 % intervals.</p>\n<figure class=\"forest\">" + plot +
                              "</figure>\n";
  }
  return "";
}

// For a study of many settings.
std::string beside_settings(const StudyPage& page) {
  const std::string plot = settings_plot(page.table, page.analysis, page.arm_settings);
  return plot.empty()
             ? plot
             : "<h2>Settings beside the result</h2>\n<p class=\"soft\">A line is a scheme: its settings "
               "that are numbers, and the mean of the primary metric. Blue: the best quarter.</p>\n"
               "<figure class=\"forest\">" +
                   plot + "</figure>\n";
}

std::string secondary(const StudyTable& t, const StudyAnalysis& a) {
  std::string s;
  for (std::size_t m = 0; m < t.metrics.size(); ++m)
    for (int part = kAllParts; part < int(t.parts.size()); ++part) {
      if ((m == 0 && part == kAllParts) || (part != kAllParts && t.parts.size() == 1)) continue;
      const auto pairs = family(a, m, part);
      if (std::ranges::all_of(pairs, [](const ArmComparison* c) { return c->values.pairs == 0; })) continue;
      s += "<details><summary>" + escape_html(t.metrics[m].name) + ", " + escape_html(part_name(t, part)) +
           "</summary>\n" + pairs_table(t, pairs) + "</details>\n";
    }
  if (s.empty()) return s;
  return "<h2>Secondary results</h2>\n<p class=\"soft\">Other metrics, and single parts. Holm's adjustment "
         "holds within each table, not over "
         "all of them: take these as hints.</p>\n" +
         s;
}

std::string settings(const std::string& title, const std::vector<std::string>& names,
                     const std::vector<DifferingParameter>& parameters) {
  return parameters.empty() ? "" : "<h2>" + title + "</h2>\n" + settings_table(parameters, names);
}

std::string failures(const StudyTable& t) {
  std::string body;
  int shown = 0, all = 0;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    for (std::size_t p = 0; p < t.parts.size(); ++p)
      for (std::size_t s = 0; s < t.seeds.size(); ++s) {
        const StudyRun& r = t.run(arm, p, s);
        if (!(r.failed() || !r.finished) || (++all, ++shown > 50)) continue;
        body += row({escape_html(t.arms[arm]), escape_html(t.parts[p]), std::to_string(t.seeds[s]),
                     escape_html(r.finished && r.failed() ? "OUT OF TOLERANCE" : r.outcome),
                     escape_html(for_people(r.reason))});
      }
  if (all == 0) return "<p class=\"soft\">All prints ran to their end, none out of tolerance.</p>\n";
  return "<h2>Prints that stopped or ended out of tolerance: " + std::to_string(all) + "</h2>\n" +
         (all > 50 ? "<p class=\"soft\">The first 50; runs.csv has all.</p>\n" : "") +
         table_of({"scheme", "part", t.trial, "outcome", "reason"}, body, "text");
}

std::string csv_text(std::string text) {
  std::string s = "\"";
  for (char c : text) s += c == '"' ? std::string("\"\"") : std::string(1, c);
  return s + "\"";
}

}  // namespace

std::string study_page(const StudyPage& page) {
  const StudyTable& t = page.table;
  const StudyAnalysis& a = page.analysis;
  std::string s =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Firn: " +
      escape_html(t.name) + "</title>\n<style>";
  s += kReportStyle;
  s += "\nsummary { cursor: pointer; margin: 6px 0; } .forest { max-width: 760px; margin-bottom: 16px; "
       "}</style></head><body>\n<h1>Study: " +
       escape_html(t.name) + "</h1>\n";
  s += "<p><b>" + escape_html(a.answer) + "</b></p>\n";
  for (const std::string& n : a.notes) s += "<p class=\"bad\">" + escape_html(n) + ".</p>\n";
  s += "<p class=\"soft\">" + counted(t.arms.size(), "scheme") + ", " + counted(t.parts.size(), "part") +
       ", " + counted(t.seeds.size(), t.trial) + ". Primary metric: " + escape_html(t.metrics[0].meaning) +
       "; smaller is better. Means over parts and " + t.trial + "s with 95 % intervals (BCa bootstrap over " +
       t.trial + "s).</p>\n";
  s += arms_table(t, a, kAllParts) + metric_meanings(t);
  if (const auto ratios = study_ratios(t)) s += ratios_section(t, *ratios);
  s += profile_section(t, profile_rows(t)) + trade_off(t, a) + beside_settings(page) +
       plots(t, a, page.nature);
  if (const auto pairs = family(a, 0, kAllParts); !pairs.empty()) s += pairs_table(t, pairs);
  s += secondary(t, a) + settings("Settings that differ between the schemes", t.arms, page.arm_settings) +
       settings("Settings that differ between the parts", t.parts, page.part_settings) + failures(t);
  std::string body;
  for (const auto& [key, value] : page.provenance) body += row({escape_html(key), escape_html(value)});
  return s + "<h2>Provenance</h2>\n" + table_of({"", ""}, body, "text") + "</body></html>\n";
}

std::string study_csv(const StudyTable& t) {
  std::string s = "scheme,part," + t.trial + ",finished,outcome,within_tolerance";
  for (const StudyMetric& m : t.metrics) s += "," + m.name;
  s += ",reason\n";
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    for (std::size_t p = 0; p < t.parts.size(); ++p)
      for (std::size_t k = 0; k < t.seeds.size(); ++k) {
        const StudyRun& r = t.run(arm, p, k);
        s += csv_text(t.arms[arm]) + "," + csv_text(t.parts[p]) + "," + std::to_string(t.seeds[k]) + "," +
             (r.finished ? "1" : "0") + "," + csv_text(r.outcome) + "," +
             (r.within ? *r.within ? "1" : "0" : "");
        for (const double v : r.metrics) {
          char digits[40];
          s += "," + (std::isfinite(v)
                          ? std::string(digits, std::to_chars(digits, digits + sizeof digits, v).ptr)
                          : std::string());
        }
        s += "," + csv_text(r.reason) + "\n";
      }
  return s;
}

}  // namespace firn::report
