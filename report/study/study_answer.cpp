#include "report/study/study_answer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/options/for_people.h"
#include "core/statistics/sign_flip.h"

namespace firn::report {
namespace {

std::string fixed(double v, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, v);
  return text;
}

std::string with_interval(double by, double low, double high, const StudyMetric& m) {
  if (low > high) std::swap(low, high);
  return fixed(by, m.decimals) + " " + m.unit +
         (std::isfinite(low) ? " [" + fixed(low, m.decimals) + ", " + fixed(high, m.decimals) + "]" : "");
}

std::string trials_text(const StudyTable& t, std::size_t n) { return counted(n, t.trial); }

// "all 16", "3 of 16"
std::string count_text(const StudyTable& t, int n) {
  const std::size_t planned = t.parts.size() * t.seeds.size();
  return (std::size_t(n) == planned ? "all " : std::to_string(n) + " of ") + std::to_string(planned);
}

bool any_failed(const StudyAnalysis& a, std::size_t arm) { return a.stopped[arm] + a.out[arm] > 0; }

// Of a pair: "; 3 of 16 prints of arm stopped"
std::string pair_failures(const StudyTable& t, const StudyAnalysis& a, std::size_t better,
                          std::size_t other) {
  std::string s;
  for (const std::size_t arm : {better, other})
    if (any_failed(a, arm)) s += "; " + t.arms[arm] + ": " + failures_text(t, a, arm);
  return s;
}

// The pair seen from `better`: the amount by which its metric is smaller than that of `other`.
std::string lead_text(const StudyTable& t, const StudyAnalysis& a, std::size_t better, std::size_t other) {
  const ArmComparison& c = a.primary(better, other);
  const double sign = c.a == better ? -1.0 : 1.0;
  const double by = sign * c.values.difference,
               mean_other = c.a == better ? c.values.mean_b : c.values.mean_a;
  std::string s =
      with_interval(by, sign * c.values.interval.low, sign * c.values.interval.high, t.metrics[0]);
  if (mean_other > 0.0 && by >= 0.0) s += " (" + fixed(100.0 * by / mean_other, 0) + " %)";
  return s;
}

std::string over_text(const StudyTable& t, const ArmComparison& c) {
  return c.left_out == 0 ? "" : "over the " + trials_text(t, c.values.pairs) + " that both completed ";
}

std::string smallest_text(const ArmComparison& c) {
  return c.at_smallest_p() ? ", the smallest possible" : "";
}

// "0.53 um below open loop", or "2 failed prints against 16 of open loop"
std::string below_text(const StudyTable& t, const StudyAnalysis& a, std::size_t better, std::size_t other,
                       const std::string& which) {
  const ArmComparison& c = a.primary(better, other);
  if (c.values.pairs == 0 || (c.by_failures() && !c.by_values()))
    return "ahead of " + t.arms[other] + which + " by failed prints" + pair_failures(t, a, better, other);
  return over_text(t, c) + lead_text(t, a, better, other) + " below " + t.arms[other] + which +
         pair_failures(t, a, better, other);
}

// "arm is better than open loop by 0.53 um (Holm p = 0.02)"
std::string better_text(const StudyTable& t, const StudyAnalysis& a, std::size_t better, std::size_t other,
                        const std::string& which) {
  const ArmComparison& c = a.primary(better, other);
  return t.arms[better] + " is better than " + which + t.arms[other] +
         (c.by_values() ? " " + over_text(t, c) + "by " + lead_text(t, a, better, other)
                        : " by failed prints") +
         " (Holm p " + p_text(c.decisive_p()) + smallest_text(c) + pair_failures(t, a, better, other) + ")";
}

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t kMostNamed = 6;  // a design has as many schemes as points
  if (names.size() > kMostNamed)
    return names.front() + " and " + std::to_string(names.size() - 1) + " other schemes";
  std::string s;
  for (std::size_t n = 0; n < names.size(); ++n)
    s += (n == 0 ? "" : n + 1 == names.size() ? " and " : ", ") + names[n];
  return s;
}

bool told_apart(const StudyAnalysis& a, std::size_t x, std::size_t y) { return a.primary(x, y).told_apart(); }

std::string sure_text(const StudyTable& t, const ArmComparison& c, std::size_t family) {
  return "Holm p " + p_text(c.decisive_p()) + (c.by_failures() && !c.by_values() ? " of the failures" : "") +
         (family > 1 ? " among " + std::to_string(family) + " pairs of schemes" : "") + ", " +
         trials_text(t, t.seeds.size()) + smallest_text(c);
}

// Part by part, a pair may go either way where the mean over all parts shows nothing.
void note_disagreement(const StudyTable& t, const StudyAnalysis& a, std::size_t x, std::size_t y,
                       std::vector<std::string>& notes) {
  std::string sides[2];  // where x is better, where y is
  for (const ArmComparison& c : a.comparisons) {
    if (c.metric != 0 || c.part == kAllParts || !c.told_apart() ||
        !((c.a == x && c.b == y) || (c.a == y && c.b == x)))
      continue;
    std::string& side = sides[c.better() == x ? 0 : 1];
    side += (side.empty() ? "" : ", ") + t.parts[std::size_t(c.part)] + " by " +
            (!c.by_values()
                 ? "failed prints"
                 : fixed(std::abs(c.values.difference), t.metrics[0].decimals) + " " + t.metrics[0].unit);
  }
  if (!sides[0].empty() && !sides[1].empty())
    notes.push_back("The parts disagree: " + t.arms[x] + " is better on " + sides[0] + "; " + t.arms[y] +
                    " on " + sides[1]);
}

}  // namespace

std::string failures_text(const StudyTable& t, const StudyAnalysis& a, std::size_t arm) {
  std::string s;
  if (a.stopped[arm] > 0) s = count_text(t, a.stopped[arm]) + " prints stopped";
  if (a.out[arm] > 0) s += (s.empty() ? "" : ", ") + count_text(t, a.out[arm]) + " OUT OF TOLERANCE";
  return s;
}

std::string p_text(double p) {
  if (p < 0.001) return "< 0.001";
  return "= " + fixed(p, p < 0.1 ? 3 : 2);
}

std::string study_answer(const StudyTable& t, const StudyAnalysis& a) {
  if (a.ranking.empty() && std::ranges::all_of(t.runs, [](const StudyRun& r) { return r.finished; }))
    return "No print has a " + t.metrics[0].name + ": nothing can be compared.";
  if (a.ranking.empty())
    return "No scheme finished every part of any " + t.trial + ": nothing can be compared.";
  const std::size_t best = a.ranking.front();
  const StudyMetric& m = t.metrics[0];
  const ArmSummary& summary = a.summaries[best];
  const std::string mean =
      summary.seeds == 0 ? "nowhere complete" : fixed(summary.mean, m.decimals) + " " + m.unit;
  const std::string of_best =
      m.name + " " + mean + (any_failed(a, best) ? " (" + failures_text(t, a, best) + ")" : "");
  if (a.ranking.size() == 1)
    return t.arms[best] + " has " + of_best + "; there is no other scheme to compare it with.";
  const std::size_t family = t.arms.size() * (t.arms.size() - 1) / 2;

  std::vector<std::size_t> equals, behind;
  for (const std::size_t arm : a.ranking)
    if (arm != best) (told_apart(a, best, arm) ? behind : equals).push_back(arm);
  std::string s;
  if (equals.empty()) {
    const std::size_t next = a.ranking[1];
    s = t.arms[best] + " is better: " + of_best + ", " +
        below_text(t, a, best, next, a.ranking.size() > 2 ? ", the next best" : "") + " (" +
        sure_text(t, a.primary(best, next), family) + ")";
  } else {
    std::vector<std::string> names{t.arms[best]};
    for (const std::size_t arm : equals) names.push_back(t.arms[arm]);
    const std::size_t farthest = equals.back();
    const ArmComparison& c = a.primary(best, farthest);
    s = joined(names) + " are not distinguishable in " + m.name + ": ";
    if (equals.size() == 1 && !c.any_failed() && c.values.difference == 0.0 && c.values.interval.low == 0.0 &&
        c.values.interval.high == 0.0)
      s += mean + ", equal for all " + trials_text(t, c.values.pairs);
    else
      s += of_best.substr(m.name.size() + 1) + " with " + t.arms[best] + ", " +
           (c.values.pairs == 0 ? "no " + t.trial + " that " + t.arms[farthest] + " completed too"
                                : (equals.size() > 1 ? "at most " : "") + over_text(t, c) +
                                      lead_text(t, a, best, farthest) + " more with " + t.arms[farthest]) +
           (any_failed(a, farthest) ? ": " + failures_text(t, a, farthest) : "") + " (" +
           sure_text(t, c, family) + ")";
    if (!behind.empty()) s += "; " + better_text(t, a, best, behind.front(), "");
  }
  const auto base = std::find(t.arms.begin(), t.arms.end(), t.baseline);
  const std::size_t b = std::size_t(base - t.arms.begin());
  const bool said =
      b == best || (equals.empty() ? b == a.ranking[1] : !behind.empty() && b == behind.front());
  if (base != t.arms.end() && !said && told_apart(a, best, b))
    s += "; " + better_text(t, a, best, b, "the baseline ");
  return s + ".";
}

std::vector<std::string> study_notes(const StudyTable& t, const StudyAnalysis& a) {
  std::vector<std::string> notes = t.notes;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    if (any_failed(a, arm))
      notes.push_back(
          t.arms[arm] + ": " + failures_text(t, a, arm) +
          ". Each counts against the scheme; one that stopped before its part was within tolerance "
          "is in no mean, interval or difference");
  for (std::size_t n = 1; n < a.ranking.size(); ++n)
    note_disagreement(t, a, a.ranking[0], a.ranking[n], notes);
  if (const std::string few = few_seeds_note(t.arms.size(), t.seeds.size(), t.trial); !few.empty())
    notes.push_back(few);
  return notes;
}

std::string few_seeds_note(std::size_t arms, std::size_t seeds, const std::string& trial) {
  const std::size_t family = arms * (arms - 1) / 2;
  const double smallest = double(family) * statistics::smallest_p(seeds);
  if (arms < 2 || smallest <= kAlpha) return "";
  return counted(seeds, trial) + " cannot tell " + counted(family, "pair") +
         " apart at 5 %: even the clearest result would have Holm p " + p_text(std::min(1.0, smallest));
}

}  // namespace firn::report
