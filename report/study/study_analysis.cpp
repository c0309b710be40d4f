#include "report/study/study_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "core/statistics/holm.h"
#include "core/statistics/sign_flip.h"
#include "core/statistics/worst_rank.h"
#include "report/study/study_answer.h"

namespace firn::replay {
namespace {

using statistics::PairedComparison;

// Returns the metric of an arm for one seed: on one part, or the mean over all parts. Nothing if a print did
// not finish.
std::optional<double> value_of(const StudyTable& t, std::size_t arm, int part, std::size_t seed,
                               std::size_t metric) {
  double sum = 0.0;
  const std::size_t first = part == kAllParts ? 0 : std::size_t(part),
                    last = part == kAllParts ? t.parts.size() : first + 1;
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

// Holds the comparison of two arms for one seed: nothing if a complete print has no value.
struct SeedOutcome {
  bool known = true, complete = true;
  double value_a = 0.0, value_b = 0.0;  // means over all parts, if complete
  statistics::PairOutcome pair;         // over the parts that both completed
  std::size_t stopped_a = 0, stopped_b = 0;
};

SeedOutcome outcome_of(const StudyTable& t, std::size_t a, std::size_t b, int part, std::size_t seed,
                       std::size_t metric) {
  const std::size_t first = part == kAllParts ? 0 : std::size_t(part),
                    last = part == kAllParts ? t.parts.size() : first + 1;
  SeedOutcome o;
  double both = 0.0;
  for (std::size_t p = first; p < last; ++p) {
    const StudyRun &ra = t.run(a, p, seed), &rb = t.run(b, p, seed);
    o.stopped_a += !ra.finished;
    o.stopped_b += !rb.finished;
    if ((ra.finished && !std::isfinite(ra.metrics[metric])) ||
        (rb.finished && !std::isfinite(rb.metrics[metric])))
      o.known = false;
    if (!ra.finished || !rb.finished) continue;
    o.value_a += ra.metrics[metric];
    o.value_b += rb.metrics[metric];
    both += 1.0;
  }
  o.complete = o.known && o.stopped_a + o.stopped_b == 0;
  o.pair.stops = double(o.stopped_a) - double(o.stopped_b);
  if (both > 0.0) {
    o.value_a /= both;
    o.value_b /= both;
    o.pair.difference = o.value_a - o.value_b;
  }
  return o;
}

ArmComparison compare(const StudyTable& t, std::size_t a, std::size_t b, int part, std::size_t metric) {
  ArmComparison c;
  c.a = a;
  c.b = b;
  c.metric = metric;
  c.part = part;
  std::vector<double> x, y;
  std::vector<statistics::PairOutcome> outcomes;
  for (std::size_t s = 0; s < t.seeds.size(); ++s) {
    const SeedOutcome o = outcome_of(t, a, b, part, s, metric);
    if (!o.known) continue;
    outcomes.push_back(o.pair);
    c.stopped_a += o.stopped_a;
    c.stopped_b += o.stopped_b;
    if (o.complete) {
      x.push_back(o.value_a);
      y.push_back(o.value_b);
    }
  }
  c.values = statistics::compare_pairs(x, y);
  c.lead = c.values.difference;
  c.tested = outcomes.size();
  c.left_out = t.seeds.size() - x.size();
  if (!c.by_rank()) return c;
  const std::vector<double> ranks = statistics::signed_worst_ranks(outcomes);
  c.values.p = statistics::sign_flip_p(ranks);
  c.lead = c.values.a_below_b = 0.0;
  for (const double r : ranks) {
    c.lead += r;
    c.values.a_below_b += r < 0.0 ? 1.0 : r == 0.0 ? 0.5 : 0.0;
  }
  c.values.a_below_b /= double(ranks.size());
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

// Without stops: by the mean. With them: by the pairs that an arm leads, since means cover only prints that
// did not stop.
void rank(const StudyTable& t, StudyAnalysis& a) {
  if (std::ranges::none_of(a.ranking, [&](std::size_t arm) { return a.summaries[arm].seeds > 0; }))
    return a.ranking.clear();
  std::vector<double> led(t.arms.size(), 0.0);
  for (const ArmComparison& c : a.comparisons) {
    if (c.metric != 0 || c.part != kAllParts) continue;
    led[c.a] += c.lead < 0.0 ? 1.0 : c.lead == 0.0 ? 0.5 : 0.0;
    led[c.b] += c.lead > 0.0 ? 1.0 : c.lead == 0.0 ? 0.5 : 0.0;
  }
  const bool stops = std::ranges::any_of(a.failed, [](int n) { return n > 0; });
  const auto mean = [&](std::size_t arm) {
    return a.summaries[arm].seeds > 0 ? a.summaries[arm].mean : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(a.ranking.begin(), a.ranking.end(), [&](std::size_t x, std::size_t y) {
    if (stops && led[x] != led[y]) return led[x] > led[y];
    return mean(x) < mean(y);
  });
}

}  // namespace

bool ArmComparison::at_smallest_p() const {
  return values.p < 1.0 && values.p <= statistics::smallest_p(tested) * (1.0 + 1e-9);
}

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
    a.ranking.push_back(arm);
  }
  rank(t, a);
  a.answer = study_answer(t, a);
  a.notes = study_notes(t, a);
  return a;
}

}  // namespace firn::replay
