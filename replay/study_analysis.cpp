#include "replay/study_analysis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "core/statistics/holm.h"
#include "core/statistics/sign_flip.h"
#include "replay/study_answer.h"

namespace firn::replay {
namespace {

using statistics::PairedComparison;

// The metric of an arm for one seed: on one part, or the mean over all parts. Nothing where a print did not finish.
std::optional<double> value_of(const StudyTable& t, std::size_t arm, int part, std::size_t seed, std::size_t metric) {
  double sum = 0.0;
  const std::size_t first = part == kAllParts ? 0 : std::size_t(part), last = part == kAllParts ? t.parts.size() : first + 1;
  for (std::size_t p = first; p < last; ++p) {
    const StudyRun& r = t.run(arm, p, seed);
    if (!r.finished || !std::isfinite(r.metrics[metric])) return std::nullopt;
    sum += r.metrics[metric];
  }
  return sum / double(last - first);
}

ArmSummary summarise(const StudyTable& t, std::size_t arm, int part, std::size_t metric) {
  std::vector<double> x;
  for (std::size_t s = 0; s < t.seeds.size(); ++s)
    if (const auto v = value_of(t, arm, part, s, metric)) x.push_back(*v);
  return {arm, metric, part, x.size(), statistics::mean(x), statistics::bootstrap_interval(x)};
}

ArmComparison compare(const StudyTable& t, std::size_t a, std::size_t b, int part, std::size_t metric) {
  ArmComparison c;
  c.a = a, c.b = b, c.metric = metric, c.part = part;
  std::vector<double> x, y;
  for (std::size_t s = 0; s < t.seeds.size(); ++s) {
    const auto va = value_of(t, a, part, s, metric), vb = value_of(t, b, part, s, metric);
    if (va && vb) x.push_back(*va), y.push_back(*vb);
  }
  c.values = statistics::compare_pairs(x, y);
  c.left_out = t.seeds.size() - x.size();
  return c;
}

void compare_family(const StudyTable& t, int part, std::size_t metric, std::vector<ArmComparison>& out) {
  const std::size_t first = out.size();
  std::vector<double> p;
  for (std::size_t a = 0; a < t.arms.size(); ++a)
    for (std::size_t b = a + 1; b < t.arms.size(); ++b) {
      out.push_back(compare(t, a, b, part, metric));
      p.push_back(out.back().values.p);
    }
  const std::vector<double> adjusted = statistics::holm(p);
  for (std::size_t n = 0; n < adjusted.size(); ++n) out[first + n].holm_p = adjusted[n];
}

}  // namespace

const ArmComparison& StudyAnalysis::primary(std::size_t a, std::size_t b) const {
  for (const ArmComparison& c : comparisons)
    if (c.metric == 0 && c.part == kAllParts && ((c.a == a && c.b == b) || (c.a == b && c.b == a))) return c;
  throw std::out_of_range("study: no such pair of arms");
}

StudyAnalysis analyse(const StudyTable& t) {
  StudyAnalysis a;
  for (std::size_t m = 0; m < t.metrics.size(); ++m)
    for (int part = kAllParts; part < int(t.parts.size()); ++part) {
      if (part != kAllParts && t.parts.size() == 1) continue;  // the same as all parts
      for (std::size_t arm = 0; arm < t.arms.size(); ++arm) a.summaries.push_back(summarise(t, arm, part, m));
      compare_family(t, part, m, a.comparisons);
    }
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    a.failed.push_back(0);
    for (std::size_t p = 0; p < t.parts.size(); ++p)
      for (std::size_t s = 0; s < t.seeds.size(); ++s) a.failed.back() += !t.run(arm, p, s).finished;
    if (a.summaries[arm].seeds > 0) a.ranking.push_back(arm);
  }
  std::stable_sort(a.ranking.begin(), a.ranking.end(),
                   [&](std::size_t x, std::size_t y) { return a.summaries[x].mean < a.summaries[y].mean; });
  a.answer = study_answer(t, a);
  a.notes = study_notes(t, a);
  return a;
}

}  // namespace firn::replay
