#include "report/study/study_ratios.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/draw/svg.h"
#include "report/study/form.h"

namespace firn::report {
namespace {

std::optional<double> value_at(const StudyTable& t, std::size_t arm, std::size_t part, std::size_t seed) {
  const StudyRun& r = t.run(arm, part, seed);
  if (!r.complete() || !std::isfinite(r.metrics[0])) return std::nullopt;
  return r.metrics[0];
}

// ln(a / b) in the seeds of one half (0, 1), or in all (-1), where both have a value.
std::vector<double> log_ratios(const StudyTable& t, std::size_t a, std::size_t b, std::size_t part,
                               int half = -1) {
  std::vector<double> logs;
  for (std::size_t s = 0; s < t.seeds.size(); ++s) {
    if (half >= 0 && int(s % 2) != half) continue;
    const auto x = value_at(t, a, part, s), y = value_at(t, b, part, s);
    if (x && y) logs.push_back(std::log(*x / *y));
  }
  return logs;
}

// The best scheme but one in a half of the seeds, by its mean log ratio to the baseline.
std::size_t best_but(const StudyTable& t, std::size_t judged, std::size_t baseline, std::size_t part,
                     int half) {
  std::size_t best = baseline;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    if (arm == judged) continue;
    const std::vector<double> logs = log_ratios(t, arm, baseline, part, half);
    if (const double mean = statistics::mean(logs); mean < least) {
      least = mean;
      best = arm;
    }
  }
  return best;
}

std::vector<PerformanceProfile> profiles_of(const StudyTable& t) {
  std::vector<PerformanceProfile> out;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    out.push_back({arm, std::vector<double>(std::size(kProfileFactors), 0.0)});
  const double problems = double(t.parts.size() * t.seeds.size());
  for (std::size_t part = 0; part < t.parts.size(); ++part)
    for (std::size_t s = 0; s < t.seeds.size(); ++s) {
      double best = std::numeric_limits<double>::infinity();
      for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
        if (const auto v = value_at(t, arm, part, s)) best = std::min(best, *v);
      for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
        if (const auto v = value_at(t, arm, part, s))
          for (std::size_t n = 0; n < std::size(kProfileFactors); ++n)
            out[arm].share[n] += double(*v <= kProfileFactors[n] * best) / problems;
    }
  return out;
}

std::vector<ParetoPoint> pareto_of(const StudyTable& t, const std::vector<std::size_t>& metrics) {
  std::vector<ParetoPoint> points;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    ParetoPoint p{arm, {}};
    for (const std::size_t m : metrics) {
      std::vector<double> x;
      for (std::size_t part = 0; part < t.parts.size(); ++part)
        for (std::size_t s = 0; s < t.seeds.size(); ++s)
          if (const StudyRun& r = t.run(arm, part, s); r.complete() && std::isfinite(r.metrics[m]))
            x.push_back(r.metrics[m]);
      p.means.push_back(statistics::mean(x));
    }
    points.push_back(std::move(p));
  }
  for (ParetoPoint& p : points)
    for (const ParetoPoint& q : points) {
      bool no_worse = true, better = false;
      for (std::size_t n = 0; n < p.means.size(); ++n) {
        no_worse = no_worse && q.means[n] <= p.means[n];
        better = better || q.means[n] < p.means[n];
      }
      if (no_worse && better && !p.bettered_by) p.bettered_by = q.arm;
    }
  return points;
}

std::string ratio_text(double ratio, const statistics::Interval& i) {
  if (!std::isfinite(ratio)) return "-";
  if (!std::isfinite(i.low)) return form("%.2f", ratio);
  return form("%.2f [%.2f, %.2f]", ratio, i.low, i.high);
}

std::string best_names(const StudyTable& t, const JudgedPart& j) {
  return t.arms[j.best[0]] + (j.best[0] == j.best[1] ? "" : " or " + t.arms[j.best[1]]);
}

std::string verdict_text(const StudyTable& t, const StudyRatios& r) {
  std::size_t holds = 0;
  for (const JudgedPart& j : r.judged_parts) holds += j.holds;
  return t.arms[*r.judged] +
         form(" is at most %.0f %% behind the best other scheme on %zu of %zu parts",
              100.0 * (r.margin - 1.0), holds, r.judged_parts.size()) +
         (r.judged_holds() ? ": it holds" : ": it does not hold");
}

std::string cell(const std::string& text, const char* tag = "td") {
  return std::string("<") + tag + ">" + text + "</" + tag + ">";
}

std::string table_html(const std::vector<std::string>& head, const std::string& body) {
  std::string s = "<div class=\"scroll\"><table><thead>\n<tr>";
  for (const std::string& h : head) s += cell(escape_html(h), "th");
  return s + "</tr>\n</thead><tbody>\n" + body + "</tbody></table></div>\n";
}

}  // namespace

bool StudyRatios::judged_holds() const {
  return !judged_parts.empty() &&
         std::ranges::all_of(judged_parts, [](const JudgedPart& j) { return j.holds; });
}

std::optional<StudyRatios> study_ratios(const StudyTable& t) {
  const auto base = std::ranges::find(t.arms, t.baseline);
  if (base == t.arms.end() || t.arms.size() < 2) return std::nullopt;
  for (const StudyRun& r : t.runs)
    if (r.complete() && std::isfinite(r.metrics[0]) && !(r.metrics[0] > 0.0)) return std::nullopt;
  StudyRatios out;
  out.baseline = std::size_t(base - t.arms.begin());
  for (std::size_t part = 0; part < t.parts.size(); ++part)
    for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
      if (arm != out.baseline)
        out.parts.push_back({arm, part, ratio_of(log_ratios(t, arm, out.baseline, part))});
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    if (arm == out.baseline) continue;
    std::vector<std::vector<double>> groups;
    std::size_t pairs = 0;
    for (std::size_t part = 0; part < t.parts.size(); ++part) {
      groups.push_back(log_ratios(t, arm, out.baseline, part));
      pairs += groups.back().size();
    }
    const statistics::Interval i = statistics::hierarchical_interval(groups);
    out.overall.push_back({arm,
                           std::exp(statistics::mean_of_groups(groups)),
                           {std::exp(i.low), std::exp(i.high)},
                           t.parts.size() * t.seeds.size() - pairs});
  }
  std::ranges::stable_sort(out.overall, {}, [](const OverallRatio& o) {
    return std::isfinite(o.ratio) ? o.ratio : std::numeric_limits<double>::infinity();
  });
  out.profiles = profiles_of(t);
  for (std::size_t m = 0; m < t.metrics.size(); ++m)
    if (m == 0 || t.metrics[m].name == "misplaced_pct" || t.metrics[m].name == "layers")
      out.pareto_metrics.push_back(m);
  out.pareto = pareto_of(t, out.pareto_metrics);
  const auto judged = std::ranges::find(t.arms, t.judged);
  if (judged == t.arms.end()) return out;
  out.judged = std::size_t(judged - t.arms.begin());
  out.margin = t.margin;
  for (std::size_t part = 0; part < t.parts.size(); ++part) {
    JudgedPart j;
    j.part = part;
    std::vector<double> logs;
    for (const int half : {0, 1}) {
      j.best[half] = best_but(t, *out.judged, out.baseline, part, 1 - half);
      const std::vector<double> own = log_ratios(t, *out.judged, j.best[half], part, half);
      logs.insert(logs.end(), own.begin(), own.end());
    }
    j.values = ratio_of(logs);
    j.holds = j.values.upper <= out.margin;
    out.judged_parts.push_back(j);
  }
  return out;
}

std::string ratios_text(const StudyTable& t, const StudyRatios& r) {
  std::string s = "\n" + t.metrics[0].name + " by that of " + t.arms[r.baseline] +
                  ", paired: geometric mean [95 % interval]\n" + form("%-28s   %-20s", "scheme", "all parts");
  for (const std::string& part : t.parts) s += form("   %-20s", std::string(shortened(part, 20)).c_str());
  s += "\n";
  for (const OverallRatio& o : r.overall) {
    s += form("%-28s   %-20s", std::string(shortened(t.arms[o.arm], 28)).c_str(),
              ratio_text(o.ratio, o.interval).c_str());
    for (const PartRatio& p : r.parts)
      if (p.arm == o.arm) s += form("   %-20s", ratio_text(p.values.ratio, p.values.interval).c_str());
    s += o.left_out > 0 ? form("   (%zu pairs without a value)\n", o.left_out) : "\n";
  }
  s += "\nshare of prints within a factor of the best scheme of each lab:\n" + form("%-28s", "scheme");
  for (const double f : kProfileFactors) s += form(" %6.2f", f);
  for (const PerformanceProfile& p : r.profiles) {
    s += form("\n%-28s", std::string(shortened(t.arms[p.arm], 28)).c_str());
    for (const double share : p.share) s += form(" %5.0f%%", 100.0 * share);
  }
  s += "\n\nbettered in ";
  for (std::size_t n = 0; n < r.pareto_metrics.size(); ++n)
    s += (n == 0 ? "" : ", ") + t.metrics[r.pareto_metrics[n]].name;
  s += " together:\n";
  for (const ParetoPoint& p : r.pareto) {
    s += form("%-28s", std::string(shortened(t.arms[p.arm], 28)).c_str());
    for (const double v : p.means) s += form(" %9.2f", v);
    s += p.bettered_by ? "   by " + t.arms[*p.bettered_by] + "\n" : "   by none\n";
  }
  if (!r.judged) return s;
  s += "\n" + verdict_text(t, r) + "\n" +
       form("%-20s   %-20s   %-6s   %s\n", "part", "ratio", "bound",
            "best other scheme, chosen on other seeds");
  for (const JudgedPart& j : r.judged_parts)
    s +=
        form("%-20s   %-20s   %-6.3f   %s\n", std::string(shortened(t.parts[j.part], 20)).c_str(),
             ratio_text(j.values.ratio, j.values.interval).c_str(), j.values.upper, best_names(t, j).c_str());
  return s;
}

std::string ratios_section(const StudyTable& t, const StudyRatios& r) {
  std::string s = "<h2>Ratios to " + escape_html(t.arms[r.baseline]) + "</h2>\n<p class=\"soft\">" +
                  escape_html(t.metrics[0].name) + " of each " + t.trial +
                  " by that of the baseline in the same lab: geometric means with 95 % intervals; on a part "
                  "BCa over " +
                  t.trial + "s, over all parts by a bootstrap of parts and then of " + t.trial +
                  "s. The parts are those that were chosen, no sample of all.</p>\n";
  std::vector<std::string> head{"scheme", "all parts"};
  head.insert(head.end(), t.parts.begin(), t.parts.end());
  std::string body;
  for (const OverallRatio& o : r.overall) {
    body += "<tr>" + cell(escape_html(t.arms[o.arm])) + cell(ratio_text(o.ratio, o.interval));
    for (const PartRatio& p : r.parts)
      if (p.arm == o.arm)
        body += cell(std::string("<span class=\"") +
                     (p.values.interval.low > 1.0    ? "bad"
                      : p.values.interval.high < 1.0 ? "good"
                                                     : "soft") +
                     "\">" + ratio_text(p.values.ratio, p.values.interval) + "</span>");
    body += "</tr>\n";
  }
  s += table_html(head, body);
  head = {"scheme"};
  for (const double f : kProfileFactors) head.push_back(form("%.2f", f));
  body.clear();
  for (const PerformanceProfile& p : r.profiles) {
    body += "<tr>" + cell(escape_html(t.arms[p.arm]));
    for (const double share : p.share) body += cell(form("%.0f %%", 100.0 * share));
    body += "</tr>\n";
  }
  s += "<h2>Performance profiles</h2>\n<p class=\"soft\">Share of prints within this factor of the best "
       "scheme of the same lab [Dolan and Moré 2002].</p>\n" +
       table_html(head, body);
  head = {"scheme"};
  for (const std::size_t m : r.pareto_metrics) head.push_back(t.metrics[m].name);
  head.push_back("bettered in all by");
  body.clear();
  for (const ParetoPoint& p : r.pareto) {
    body += "<tr>" + cell(escape_html(t.arms[p.arm]));
    for (const double v : p.means) body += cell(form("%.2f", v));
    body += cell(p.bettered_by ? escape_html(t.arms[*p.bettered_by]) : "none") + "</tr>\n";
  }
  s += "<h2>Several metrics at once</h2>\n" + table_html(head, body);
  if (!r.judged) return s;
  body.clear();
  for (const JudgedPart& j : r.judged_parts)
    body += "<tr>" + cell(escape_html(t.parts[j.part])) +
            cell(ratio_text(j.values.ratio, j.values.interval)) +
            cell(form("<span class=\"%s\">%.3f</span>", j.holds ? "good" : "bad", j.values.upper)) +
            cell(escape_html(best_names(t, j))) + "</tr>\n";
  return s + "<h2>" + escape_html(verdict_text(t, r)) +
         "</h2>\n<p class=\"soft\">One-sided 95 % bounds of "
         "the mean ratio; the best other scheme is chosen on the other half of the " +
         t.trial + "s.</p>\n" + table_html({"part", "ratio", "bound", "best other scheme"}, body);
}

}  // namespace firn::report
