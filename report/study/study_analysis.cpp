#include "report/study/study_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "core/statistics/holm.h"
#include "core/statistics/sign_flip.h"
#include "report/study/study_answer.h"

namespace firn::report {
namespace {

using statistics::PairedComparison;

// Returns the metric of an arm for one seed: on one part, or the mean over all parts. Nothing if a print is
// not complete.
std::optional<double> value_of(const StudyTable& t, std::size_t arm, int part, std::size_t seed,
                               std::size_t metric) {
  double sum = 0.0;
  const std::size_t first = part == kAllParts ? 0 : std::size_t(part),
                    last = part == kAllParts ? t.parts.size() : first + 1;
  for (std::size_t p = first; p < last; ++p) {
    const StudyRun& r = t.run(arm, p, seed);
    if (!r.complete() || !std::isfinite(r.metrics[metric])) return std::nullopt;
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

// Holds the comparison of two arms for one seed over the parts.
struct SeedOutcome {
  double both = 0.0;                    // parts that both completed
  double value_a = 0.0, value_b = 0.0;  // means over them
  double failures = 0.0;                // of a less those of b
  double lost = 0.0;                    // pairs that a lost less those that it won
};

bool has_value(const StudyRun& r, std::size_t metric) {
  return r.complete() && std::isfinite(r.metrics[metric]);
}

ArmComparison compare(const StudyTable& t, std::size_t a, std::size_t b, int part, std::size_t metric) {
  ArmComparison c;
  c.a = a;
  c.b = b;
  c.metric = metric;
  c.part = part;
  std::vector<double> x, y, failures;
  double lost = 0.0;
  const std::size_t first = part == kAllParts ? 0 : std::size_t(part),
                    last = part == kAllParts ? t.parts.size() : first + 1;
  for (std::size_t s = 0; s < t.seeds.size(); ++s) {
    SeedOutcome o;
    for (std::size_t p = first; p < last; ++p) {
      const StudyRun &ra = t.run(a, p, s), &rb = t.run(b, p, s);
      c.failed_a += ra.failed();
      c.failed_b += rb.failed();
      o.failures += double(ra.failed()) - double(rb.failed());
      const bool values = has_value(ra, metric) && has_value(rb, metric);
      const double difference = values ? ra.metrics[metric] - rb.metrics[metric] : 0.0,
                   against =
                       ra.failed() != rb.failed() ? double(ra.failed()) - double(rb.failed()) : difference;
      o.lost += double(against > 0.0) - double(against < 0.0);
      if (!values) continue;
      o.value_a += ra.metrics[metric];
      o.value_b += rb.metrics[metric];
      o.both += 1.0;
    }
    if (o.failures != 0.0) failures.push_back(o.failures);  // a sign changes no other seed
    lost += o.lost / double((last - first) * t.seeds.size());
    if (o.both == 0.0) continue;
    x.push_back(o.value_a / o.both);
    y.push_back(o.value_b / o.both);
  }
  c.values = statistics::compare_pairs(x, y);
  c.lead = c.values.difference;
  c.left_out = t.seeds.size() - x.size();
  if (!c.any_failed()) return c;
  c.failures_p = statistics::sign_flip_p(failures);
  c.lead = lost;
  c.values.a_below_b = 0.5 - 0.5 * lost;
  return c;
}

void compare_family(const StudyTable& t, int part, std::size_t metric, std::vector<ArmComparison>& out) {
  const std::size_t first = out.size();
  std::vector<double> p, failures_p;
  for (std::size_t a = 0; a < t.arms.size(); ++a)
    for (std::size_t b = a + 1; b < t.arms.size(); ++b) {
      out.push_back(compare(t, a, b, part, metric));
      p.push_back(out.back().values.p);
      failures_p.push_back(out.back().failures_p);
    }
  const std::vector<double> adjusted = statistics::holm(p), of_failures = statistics::holm(failures_p);
  for (std::size_t n = 0; n < adjusted.size(); ++n) {
    out[first + n].holm_p = adjusted[n];
    out[first + n].failures_holm_p = of_failures[n];
  }
}

// Without failures: by the mean. With them: by the arms that an arm leads, since means cover only complete
// prints.
void rank(const StudyTable& t, StudyAnalysis& a) {
  if (std::ranges::none_of(t.runs, [](const StudyRun& r) { return has_value(r, 0); }))
    return a.ranking.clear();
  std::vector<double> led(t.arms.size(), 0.0);
  for (const ArmComparison& c : a.comparisons) {
    if (c.metric != 0 || c.part != kAllParts) continue;
    const double a_leads = c.told_apart()  ? double(c.better() == c.a)
                           : c.lead < 0.0  ? 1.0
                           : c.lead == 0.0 ? 0.5
                                           : 0.0;
    led[c.a] += a_leads;
    led[c.b] += 1.0 - a_leads;
  }
  const bool failures = std::ranges::any_of(t.runs, [](const StudyRun& r) { return r.failed(); });
  const auto mean = [&](std::size_t arm) {
    return a.summaries[arm].seeds > 0 ? a.summaries[arm].mean : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(a.ranking.begin(), a.ranking.end(), [&](std::size_t x, std::size_t y) {
    if (failures && led[x] != led[y]) return led[x] > led[y];
    return mean(x) < mean(y);
  });
}

}  // namespace

bool ArmComparison::by_values() const {
  return holm_p <= kAlpha &&
         !(failures_holm_p <= kAlpha && (values.difference < 0.0) != (failed_a < failed_b));
}

bool ArmComparison::by_failures() const {
  return failures_holm_p <= kAlpha &&
         !(holm_p <= kAlpha && (values.difference < 0.0) != (failed_a < failed_b));
}

double ArmComparison::decisive_p() const { return by_failures() && !by_values() ? failures_holm_p : holm_p; }

std::size_t ArmComparison::better() const {
  const bool a_is = by_values() ? values.difference < 0.0 : by_failures() ? failed_a < failed_b : lead < 0.0;
  return a_is ? a : b;
}

bool ArmComparison::at_smallest_p() const {
  const bool of_failures = by_failures() && !by_values();
  const double p = of_failures ? failures_p : values.p;
  return p < 1.0 &&
         p <= statistics::smallest_p(of_failures ? values.pairs + left_out : values.pairs) * (1.0 + 1e-9);
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
    a.stopped.push_back(0);
    a.out.push_back(0);
    for (std::size_t p = 0; p < t.parts.size(); ++p)
      for (std::size_t s = 0; s < t.seeds.size(); ++s) {
        const StudyRun& r = t.run(arm, p, s);
        a.stopped.back() += !r.finished;
        a.out.back() += r.finished && r.failed();
      }
    a.ranking.push_back(arm);
  }
  rank(t, a);
  a.answer = study_answer(t, a);
  a.notes = study_notes(t, a);
  return a;
}

StudyTable in_readable_units(StudyTable table) {
  constexpr double kMmPerUm = 1e-3, kFromUm = 1000.0;
  constexpr std::string_view kEnding = "_um";
  if (!table.profile.title.empty()) return table;
  for (std::size_t m = 0; m < table.metrics.size(); ++m) {
    StudyMetric& metric = table.metrics[m];
    if (metric.unit != "um" || !metric.name.ends_with(kEnding)) continue;
    if (std::ranges::none_of(table.runs,
                             [&](const StudyRun& r) { return std::abs(r.metrics[m]) >= kFromUm; }))
      continue;
    metric.name.replace(metric.name.size() - kEnding.size(), kEnding.size(), "_mm");
    metric.unit = "mm";
    metric.decimals = 3;
    for (StudyRun& r : table.runs) r.metrics[m] *= kMmPerUm;
  }
  return table;
}

}  // namespace firn::report
