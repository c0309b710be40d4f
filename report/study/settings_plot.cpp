#include "report/study/settings_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "core/options/number.h"
#include "report/draw/svg.h"
#include "report/study/form.h"

namespace firn::report {
namespace {

constexpr std::size_t kLeastArms = 4, kLeastValues = 3, kMostSettings = 8;
constexpr double kTopPx = 34, kBottomPx = 300, kApartPx = 150, kEdgePx = 70;  // of the drawing
constexpr double kLogarithmicFrom = 20.0;  // largest over smallest value, as in distribution_plot
constexpr double kBestShare = 0.25;
constexpr int kTicks = 5;

struct Upright {
  std::string name;
  std::vector<double> values;  // [arm]
  Axis axis;
};

Axis axis_of(const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax(values);
  const bool logarithmic = low > 0.0 && high >= kLogarithmicFrom * low;
  return {low, high, kBottomPx, kTopPx, kTicks, logarithmic ? Axis::Kind::kLogarithmic : Axis::Kind::kLinear};
}

// Returns one number for each arm that is drawn; empty: a value is none, or there are too few different ones.
std::vector<double> numbers_of(const DifferingParameter& p, const std::vector<std::size_t>& arms) {
  std::vector<double> values;
  for (const std::size_t arm : arms) {
    const auto v = arm < p.values.size() ? whole_number<double>(p.values[arm]) : std::nullopt;
    if (!v || !std::isfinite(*v)) return {};
    values.push_back(*v);
  }
  const std::set<double> different(values.begin(), values.end());
  return different.size() >= kLeastValues ? values : std::vector<double>();
}

double mean_of(const StudyAnalysis& a, std::size_t arm) {
  for (const ArmSummary& s : a.summaries)
    if (s.arm == arm && s.metric == 0 && s.part == kAllParts && s.seeds > 0) return s.mean;
  return std::numeric_limits<double>::quiet_NaN();
}

std::string draw(const Upright& u, double x) {
  std::string s = form("<path class=\"axis\" d=\"M%.1f %.1fV%.1f\"/>", x, kTopPx, kBottomPx), texts;
  for (const Axis::Tick& t : u.axis.ticks()) {
    s += form("<path class=\"axis\" d=\"M%.1f %.1fh-4\"/>", x, u.axis.px(t.value));
    texts += svg_text(x - 7, u.axis.px(t.value) + 4, "end", "tick", t.text);
  }
  // The lines of the schemes give way to the numbers.
  return s + "<g stroke=\"var(--card)\" stroke-width=\"4\" paint-order=\"stroke\">" + texts + "</g>" +
         svg_text(x, kTopPx - 14, "middle", "name", u.name) + "\n";
}

}  // namespace

std::string settings_plot(const StudyTable& table, const StudyAnalysis& analysis,
                          const std::vector<DifferingParameter>& settings) {
  std::vector<std::size_t> arms;
  std::vector<double> means;
  for (std::size_t arm = 0; arm < table.arms.size(); ++arm)
    if (const double mean = mean_of(analysis, arm); std::isfinite(mean)) {
      arms.push_back(arm);
      means.push_back(mean);
    }
  if (arms.size() < kLeastArms) return "";
  std::vector<Upright> uprights;
  for (const DifferingParameter& p : settings)
    if (auto values = numbers_of(p, arms); !values.empty() && uprights.size() < kMostSettings) {
      const Axis axis = axis_of(values);
      uprights.push_back({p.key.substr(p.key.rfind('.') + 1), std::move(values), axis});
    }
  if (uprights.empty()) return "";
  const StudyMetric& metric = table.metrics[0];
  uprights.push_back(
      {metric.name + (metric.unit.empty() ? "" : " [" + metric.unit + "]"), means, axis_of(means)});

  std::vector<std::size_t> order(arms.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(),
                           [&](std::size_t n) { return means[n]; });  // the best on top
  const auto best = std::size_t(std::ceil(kBestShare * double(arms.size())));
  const auto at = [](std::size_t n) { return kEdgePx + kApartPx * double(n); };
  std::string s =
      svg_open(at(uprights.size() - 1) + kEdgePx, kBottomPx + 20, "settings beside " + metric.name);
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const std::size_t n = order[rank];
    const bool good = rank + best >= order.size();
    std::string line;
    for (std::size_t u = 0; u < uprights.size(); ++u)
      line += form("%c%.1f %.1f", u == 0 ? 'M' : 'L', at(u), uprights[u].axis.px(uprights[u].values[n]));
    s += "<path fill=\"none\" stroke=\"" + std::string(good ? "var(--c0)" : "var(--soft)") +
         (good ? "\" stroke-width=\"2\" d=\"" : "\" stroke-opacity=\"0.45\" d=\"") + line + "\"><title>" +
         escape_html(table.arms[arms[n]]) + ": " + number(means[n]) + "</title></path>\n";
  }
  for (std::size_t u = 0; u < uprights.size(); ++u) s += draw(uprights[u], at(u));
  return s + "</svg>\n";
}

}  // namespace firn::report
