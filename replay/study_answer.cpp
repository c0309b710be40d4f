#include "replay/study_answer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/statistics/sign_flip.h"

namespace firn::replay {
namespace {

std::string fixed(double v, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, v);
  return text;
}

// The pair seen from `better`: how much smaller its metric is than that of `other`.
std::string lead_text(const StudyTable& t, const StudyAnalysis& a, std::size_t better, std::size_t other) {
  const ArmComparison& c = a.primary(better, other);
  const double sign = c.a == better ? -1.0 : 1.0;
  const double by = sign * c.values.difference, mean_other = c.a == better ? c.values.mean_b : c.values.mean_a;
  double low = sign * c.values.interval.low, high = sign * c.values.interval.high;
  if (low > high) std::swap(low, high);
  const StudyMetric& m = t.metrics[0];
  std::string s = fixed(by, m.decimals) + " " + m.unit;
  if (std::isfinite(low)) s += " [" + fixed(low, m.decimals) + ", " + fixed(high, m.decimals) + "]";
  if (mean_other > 0.0 && by >= 0.0) s += " (" + fixed(100.0 * by / mean_other, 0) + " %)";
  return s;
}

std::string joined(const std::vector<std::string>& names) {
  std::string s;
  for (std::size_t n = 0; n < names.size(); ++n) s += (n == 0 ? "" : n + 1 == names.size() ? " and " : ", ") + names[n];
  return s;
}

bool told_apart(const StudyAnalysis& a, std::size_t x, std::size_t y) { return a.primary(x, y).holm_p <= kAlpha; }

std::string seeds_text(std::size_t n) { return std::to_string(n) + (n == 1 ? " seed" : " seeds"); }

std::string sure_text(const ArmComparison& c, std::size_t family) {
  return "Holm p " + p_text(c.holm_p) + (family > 1 ? " among " + std::to_string(family) + " pairs of schemes" : "") + ", " +
         seeds_text(c.values.pairs);
}

// Part by part, a pair may go either way where the mean over all parts shows nothing.
void note_disagreement(const StudyTable& t, const StudyAnalysis& a, std::size_t x, std::size_t y, std::vector<std::string>& notes) {
  std::string sides[2];  // where x is better, where y is
  for (const ArmComparison& c : a.comparisons) {
    if (c.metric != 0 || c.part == kAllParts || c.holm_p > kAlpha || !((c.a == x && c.b == y) || (c.a == y && c.b == x))) continue;
    const bool x_better = (c.values.difference < 0.0) == (c.a == x);
    std::string& side = sides[x_better ? 0 : 1];
    side += (side.empty() ? "" : ", ") + t.parts[std::size_t(c.part)] + " by " +
            fixed(std::abs(c.values.difference), t.metrics[0].decimals) + " " + t.metrics[0].unit;
  }
  if (!sides[0].empty() && !sides[1].empty())
    notes.push_back("The parts disagree: " + t.arms[x] + " is better on " + sides[0] + "; " + t.arms[y] + " on " + sides[1]);
}

}  // namespace

std::string p_text(double p) {
  if (p < 0.001) return "< 0.001";
  return "= " + fixed(p, p < 0.1 ? 3 : 2);
}

std::string study_answer(const StudyTable& t, const StudyAnalysis& a) {
  if (a.ranking.empty()) return "No scheme finished every part of any seed: nothing can be compared.";
  const std::size_t best = a.ranking.front();
  const StudyMetric& m = t.metrics[0];
  const std::string mean = fixed(a.summaries[best].mean, m.decimals) + " " + m.unit;
  if (a.ranking.size() == 1) return t.arms[best] + " has " + m.name + " " + mean + "; there is no other scheme to compare it with.";
  const std::size_t family = t.arms.size() * (t.arms.size() - 1) / 2;

  std::vector<std::size_t> equals, behind;
  for (const std::size_t arm : a.ranking)
    if (arm != best) (told_apart(a, best, arm) ? behind : equals).push_back(arm);
  std::string s;
  if (equals.empty()) {
    const std::size_t next = a.ranking[1];
    s = t.arms[best] + " is better: " + m.name + " " + mean + ", " + lead_text(t, a, best, next) + " below " + t.arms[next] +
        (a.ranking.size() > 2 ? ", the next best" : "") + " (" + sure_text(a.primary(best, next), family) + ")";
  } else {
    std::vector<std::string> names{t.arms[best]};
    for (const std::size_t arm : equals) names.push_back(t.arms[arm]);
    const std::size_t farthest = equals.back();
    const ArmComparison& c = a.primary(best, farthest);
    s = joined(names) + " are not distinguishable in " + m.name + ": ";
    if (equals.size() == 1 && c.values.difference == 0.0 && c.values.interval.low == 0.0 && c.values.interval.high == 0.0)
      s += mean + ", equal for all " + seeds_text(c.values.pairs);
    else
      s += mean + " with " + t.arms[best] + ", " + (equals.size() > 1 ? "at most " : "") + lead_text(t, a, best, farthest) +
           " more with " + t.arms[farthest] + " (" + sure_text(c, family) + ")";
    if (!behind.empty())
      s += "; " + t.arms[best] + " is better than " + t.arms[behind.front()] + " by " + lead_text(t, a, best, behind.front()) +
           " (Holm p " + p_text(a.primary(best, behind.front()).holm_p) + ")";
  }
  const auto base = std::find(t.arms.begin(), t.arms.end(), t.baseline);
  const std::size_t b = std::size_t(base - t.arms.begin());
  const bool said = b == best || (equals.empty() ? b == a.ranking[1] : !behind.empty() && b == behind.front());
  if (base != t.arms.end() && !said && std::ranges::find(a.ranking, b) != a.ranking.end() && told_apart(a, best, b))
    s += "; " + t.arms[best] + " is better than the baseline " + t.baseline + " by " + lead_text(t, a, best, b) + " (Holm p " + p_text(a.primary(best, b).holm_p) + ")";
  return s + ".";
}

std::vector<std::string> study_notes(const StudyTable& t, const StudyAnalysis& a) {
  std::vector<std::string> notes;
  const std::size_t planned = t.parts.size() * t.seeds.size();
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    if (a.failed[arm] > 0)
      notes.push_back(std::to_string(a.failed[arm]) + " of " + std::to_string(planned) + " prints of " + t.arms[arm] +
                      " did not finish: their seeds are left out of its comparisons");
  for (std::size_t n = 1; n < a.ranking.size(); ++n) note_disagreement(t, a, a.ranking[0], a.ranking[n], notes);
  const std::size_t family = t.arms.size() * (t.arms.size() - 1) / 2;
  const double smallest = double(family) * statistics::smallest_p(t.seeds.size());
  if (t.arms.size() > 1 && smallest > kAlpha)
    notes.push_back(seeds_text(t.seeds.size()) + " cannot tell " + std::to_string(family) +
                    (family == 1 ? " pair" : " pairs") + " apart at 5 %: even the clearest result would have Holm p " + p_text(std::min(1.0, smallest)));
  return notes;
}

}  // namespace firn::replay
