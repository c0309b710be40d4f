#include "cli/compare_show.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "files/json.h"
#include "report/study/study_profile.h"
#include "report/study/study_ratios.h"

namespace firn {
namespace {

using report::ArmComparison;
using report::ArmSummary;
using report::StudyAnalysis;
using report::StudyTable;
using Json = nlohmann::ordered_json;

Json real(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

std::string part_name(const StudyTable& t, int part) {
  return part == report::kAllParts ? "" : t.parts[std::size_t(part)];
}

std::size_t widest(const std::vector<std::string>& names, std::size_t least) {
  for (const std::string& n : names) least = std::max(least, n.size());
  return least;
}

std::string interval(double value, const statistics::Interval& i, int decimals) {
  if (!std::isfinite(value)) return "-";
  if (!std::isfinite(i.low)) return fmt::format("{:.{}f}", value, decimals);
  return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}]", value, decimals, i.low, decimals, i.high, decimals);
}

// The primary metric on each part: a column a part.
std::string part_table(const StudyTable& t, const StudyAnalysis& a, std::size_t name_width) {
  std::string s = fmt::format("\n{}, part by part:\n{:<{}}", t.metrics[0].name, "scheme", name_width);
  for (const std::string& part : t.parts) s += fmt::format("   {:<25}", part);
  s += "\n";
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    s += fmt::format("{:<{}}", t.arms[arm], name_width);
    for (const ArmSummary& one : a.summaries)
      if (one.arm == arm && one.metric == 0 && one.part != report::kAllParts)
        s += fmt::format("   {:<25}", interval(one.mean, one.interval, t.metrics[0].decimals));
    s += "\n";
  }
  return s;
}

Json summary_json(const report::RatioSummary& r) {
  return {{"pairs", r.pairs},
          {"ratio", real(r.ratio)},
          {"low", real(r.interval.low)},
          {"high", real(r.interval.high)},
          {"p", r.p},
          {"upper", real(r.upper)}};
}

Json ratios_json(const StudyTable& t, const report::StudyRatios& r) {
  Json overall = Json::array(), parts = Json::array(), profiles = Json::array(), pareto = Json::array();
  for (const report::OverallRatio& o : r.overall)
    overall.push_back({{"scheme", t.arms[o.arm]},
                       {"ratio", real(o.ratio)},
                       {"low", real(o.interval.low)},
                       {"high", real(o.interval.high)},
                       {"left_out", o.left_out}});
  for (const report::PartRatio& p : r.parts) {
    Json one = {{"scheme", t.arms[p.arm]}, {"part", t.parts[p.part]}};
    one.update(summary_json(p.values));
    parts.push_back(one);
  }
  for (const report::PerformanceProfile& p : r.profiles)
    profiles.push_back({{"scheme", t.arms[p.arm]}, {"share", p.share}});
  for (const report::ParetoPoint& p : r.pareto) {
    Json one = {{"scheme", t.arms[p.arm]}};
    for (std::size_t n = 0; n < p.means.size(); ++n)
      one[t.metrics[r.pareto_metrics[n]].name] = real(p.means[n]);
    one["bettered_by"] = p.bettered_by ? Json(t.arms[*p.bettered_by]) : Json(nullptr);
    pareto.push_back(one);
  }
  Json j = {{"baseline", t.arms[r.baseline]},
            {"over_parts", overall},
            {"parts", parts},
            {"profile_factors", report::kProfileFactors},
            {"profiles", profiles},
            {"pareto", pareto}};
  if (!r.judged) return j;
  Json judged = Json::array();
  for (const report::JudgedPart& one : r.judged_parts) {
    Json p = {{"part", t.parts[one.part]},
              {"best", {t.arms[one.best[0]], t.arms[one.best[1]]}},
              {"holds", one.holds}};
    p.update(summary_json(one.values));
    judged.push_back(p);
  }
  j["judged"] = {
      {"scheme", t.arms[*r.judged]}, {"margin", r.margin}, {"holds", r.judged_holds()}, {"parts", judged}};
  return j;
}

}  // namespace

std::string study_text(const StudyTable& t, const StudyAnalysis& a,
                       const std::vector<report::DifferingParameter>& settings) {
  const std::size_t w = widest(t.arms, 6);
  std::string s;
  for (const std::string& n : a.notes) s += n + ".\n";
  s += fmt::format(
      "{}: {} schemes, {} parts, {} {}s; means over all parts with 95 % intervals, smaller is better\n",
      t.name, t.arms.size(), t.parts.size(), t.seeds.size(), t.trial);
  s += fmt::format("{:<{}} {:>5} {:>8} {:>16}", "scheme", w, t.trial + "s", "stopped", "OUT OF TOLERANCE");
  for (const auto& m : t.metrics) s += fmt::format("   {:<25}", m.name);
  s += "\n";
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    const std::size_t prints = t.parts.size() * t.seeds.size();
    s += fmt::format("{:<{}} {:>5} {:>8} {:>16}", t.arms[arm], w, a.summaries[arm].seeds,
                     fmt::format("{}/{}", a.stopped[arm], prints), fmt::format("{}/{}", a.out[arm], prints));
    for (const ArmSummary& one : a.summaries)
      if (one.arm == arm && one.part == report::kAllParts)
        s += fmt::format("   {:<25}", interval(one.mean, one.interval, t.metrics[one.metric].decimals));
    s += "\n";
  }
  if (t.parts.size() > 1) s += part_table(t, a, w);
  if (!settings.empty()) {
    s += "\nsettings that differ:\n";
    for (const auto& p : settings) {
      s += fmt::format("  {:<32}", p.key);
      for (std::size_t n = 0; n < p.values.size(); ++n)
        s += fmt::format(" {}: {}{}", t.arms[n], p.values[n], n + 1 < p.values.size() ? "," : "");
      s += "\n";
    }
  }
  if (t.arms.size() > 1) s += fmt::format("\n{}, pair by pair (first - second):\n", t.metrics[0].name);
  for (const ArmComparison& c : a.comparisons) {
    if (c.metric != 0 || c.part != report::kAllParts) continue;
    s += fmt::format(
        "  {:<{}} - {:<{}} {:<26} effect d_z {:>7}   Holm p {:<8} {}{}\n", t.arms[c.a], w, t.arms[c.b], w,
        interval(c.values.difference, c.values.interval, t.metrics[0].decimals),
        c.values.pairs > 0 ? fmt::format("{:.2f}", c.values.effect) : "-", report::p_text(c.holm_p),
        !c.told_apart()     ? "not distinguishable"
        : c.at_smallest_p() ? fmt::format("(the smallest p that {} {}s can give)", t.seeds.size(), t.trial)
                            : "",
        c.any_failed() ? fmt::format(" (failed prints {} : {}, Holm p {}; difference over {} of {} {}s)",
                                     c.failed_a, c.failed_b, report::p_text(c.failures_holm_p),
                                     c.values.pairs, t.seeds.size(), t.trial)
                       : "");
  }
  if (const auto ratios = report::study_ratios(t)) s += report::ratios_text(t, *ratios);
  return s + report::profile_text(t, report::profile_rows(t)) + "\n" + a.answer + "\n";
}

std::string study_json(const StudyTable& t, const StudyAnalysis& a,
                       const std::vector<std::pair<std::string, std::string>>& provenance) {
  Json schemes = Json::array();
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    Json metrics = Json::array();
    for (const ArmSummary& s : a.summaries)
      if (s.arm == arm)
        metrics.push_back({{"metric", t.metrics[s.metric].name},
                           {"part", part_name(t, s.part)},
                           {"seeds", s.seeds},
                           {"mean", real(s.mean)},
                           {"low", real(s.interval.low)},
                           {"high", real(s.interval.high)}});
    schemes.push_back({{"name", t.arms[arm]},
                       {"failed_prints", a.stopped[arm]},
                       {"out_of_tolerance", a.out[arm]},
                       {"means_of", a.stopped[arm] ? "complete prints" : "all prints"},
                       {"prints", t.parts.size() * t.seeds.size()},
                       {"metrics", metrics}});
  }
  Json comparisons = Json::array();
  for (const ArmComparison& c : a.comparisons)
    comparisons.push_back({{"a", t.arms[c.a]},
                           {"b", t.arms[c.b]},
                           {"metric", t.metrics[c.metric].name},
                           {"part", part_name(t, c.part)},
                           {"primary", c.metric == 0 && c.part == report::kAllParts},
                           {"seeds", t.seeds.size()},
                           {"seeds_complete", c.values.pairs},
                           {"left_out", c.left_out},
                           {"failed_a", c.failed_a},
                           {"failed_b", c.failed_b},
                           {"failures_p", c.failures_p},
                           {"failures_holm_p", c.failures_holm_p},
                           {"mean_a", real(c.values.mean_a)},
                           {"mean_b", real(c.values.mean_b)},
                           {"difference", real(c.values.difference)},
                           {"low", real(c.values.interval.low)},
                           {"high", real(c.values.interval.high)},
                           {"effect_dz", real(c.values.effect)},
                           {"a_smaller", real(c.values.a_below_b)},
                           {"p", c.values.p},
                           {"p_is_smallest_possible", c.at_smallest_p()},
                           {"holm_p", c.holm_p},
                           {"distinguishable", c.told_apart()},
                           {"better", c.told_apart() ? Json(t.arms[c.better()]) : Json(nullptr)}});
  Json profile = Json::array();
  for (const report::ProfileRow& r : report::profile_rows(t))
    profile.push_back({{"scheme", t.arms[r.arm]},
                       {"part", t.parts[r.part]},
                       {t.profile.x_name, r.x},
                       {"seeds", r.seeds},
                       {"mean", real(r.mean)},
                       {"low", real(r.interval.low)},
                       {"high", real(r.interval.high)},
                       {"least", real(r.least)},
                       {"largest", real(r.largest)}});
  Json j = {{"study", t.name},
            {"answer", a.answer},
            {"notes", a.notes},
            {"primary", t.metrics[0].name},
            {"parts", t.parts},
            {"seeds", t.seeds.size()},
            {"schemes", schemes},
            {"comparisons", comparisons},
            {"files", {"runs.csv", "summary.json", "report.html"}}};
  if (t.trial == "seed")  // printed here
    for (const char* file : {"study.toml", "results.journal"}) j["files"].push_back(file);
  for (const auto& [name, value] : provenance) j["provenance"][name] = value;
  if (const auto ratios = report::study_ratios(t)) j["ratios"] = ratios_json(t, *ratios);
  if (!profile.empty()) {
    j["profile"] = profile;
    j["files"].push_back("profile.csv");
  }
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace firn
