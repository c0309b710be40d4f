#include "report/study/study_plots.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/grid/random.h"
#include "report/draw/svg.h"
#include "report/study/form.h"

namespace firn::report {
namespace {

constexpr double kRow = 30, kRight = 640, kTop = 8;
constexpr double kNames = 150, kPairNames = 330;  // room for the rows' names
constexpr double kBeside = 6;                     // of a text and the axis

// Ticks below, names of the rows at the left.
std::string frame(const Axis& x, double left, const std::vector<std::string>& rows,
                  const std::string& x_name) {
  const std::size_t most = std::size_t((left - 14) / 6.6);
  const double bottom = kTop + kRow * double(rows.size());
  std::string s;
  for (const Axis::Tick& t : x.ticks()) {
    s += form("<path class=\"grid\" d=\"M%.1f %.1fV%.1f\"/>", x.px(t.value), kTop, bottom);
    s += svg_text(x.px(t.value), bottom + 17, "middle", "tick", t.text);
  }
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const std::string shown =
        rows[n].size() > most ? std::string(shortened(rows[n], most - 1)) + "…" : rows[n];
    s += svg_text(left - 10, kTop + kRow * (double(n) + 0.5) + 4, "end", "tick", shown);
  }
  s += form("<path class=\"axis\" d=\"M%.1f %.1fH%.1f\"/>", left, bottom, kRight);
  return s + svg_text((left + kRight) / 2, bottom + 36, "middle", "name", x_name);
}

double total_height(std::size_t rows) { return kTop + kRow * double(rows) + 44; }

std::string interval_mark(const Axis& x, double y, double low, double mean, double high,
                          const std::string& colour) {
  return form("<path d=\"M%.1f %.1fH%.1f\" stroke=\"", x.px(low), y, x.px(high)) + colour +
         "\" stroke-width=\"3\" stroke-linecap=\"round\"/>" +
         form("<path d=\"M%.1f %.1fv14\" stroke=\"", x.px(mean), y - 7) + colour +
         "\" stroke-width=\"3\"/>\n";
}

const ArmSummary* find(const StudyAnalysis& a, std::size_t arm, int part, std::size_t metric) {
  for (const ArmSummary& s : a.summaries)
    if (s.arm == arm && s.part == part && s.metric == metric) return &s;
  return nullptr;
}

}  // namespace

std::string distribution_plot(const StudyTable& t, const StudyAnalysis& a, int part, std::size_t metric) {
  struct Dot {
    std::size_t arm, seed;
    double value;
  };
  std::vector<Dot> dots;
  double low = INFINITY, high = -INFINITY;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    for (std::size_t s = 0; s < t.seeds.size(); ++s) {
      const StudyRun& r = t.run(arm, std::size_t(std::max(0, part)), s);
      if (!r.complete() || !std::isfinite(r.metrics[metric])) continue;
      dots.push_back({arm, s, r.metrics[metric]});
      low = std::min(low, dots.back().value);
      high = std::max(high, dots.back().value);
    }
  if (dots.empty()) return "<p class=\"soft\">no finished print</p>\n";
  const bool logarithmic = low > 0.0 && high > 20.0 * low;
  if (!logarithmic && low >= 0.0 && low < 0.5 * high) low = 0.0;
  const Axis x(logarithmic ? 0.9 * low : low, logarithmic ? 1.1 * high : high, kNames, kRight, 7,
               logarithmic ? Axis::Kind::kLogarithmic : Axis::Kind::kLinear);
  const StudyMetric& m = t.metrics[metric];
  std::string s = svg_open(660, total_height(t.arms.size()), m.meaning);
  s += frame(x, kNames, t.arms,
             m.name + (logarithmic ? ", logarithmic"
                                   : ""));  // its meaning is above the plots; here it would not fit
  for (const Dot& d : dots) {
    // Dots are spread a little, the same way every time.
    const double spread =
        random_uniform({t.seeds[d.seed], Purpose::kInstance, 0, 0, std::uint32_t(d.arm)}) - 0.5;
    s += form("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.2\" fill-opacity=\"0.4\" fill=\"var(--c%zu)\"/>",
              x.px(d.value), kTop + kRow * (double(d.arm) + 0.5 + 0.45 * spread), d.arm % 6);
  }
  s += "\n";
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    std::size_t failed = 0;
    for (std::size_t k = 0; k < t.seeds.size(); ++k)
      failed += t.run(arm, std::size_t(std::max(0, part)), k).failed();
    if (failed > 0)
      s += svg_text(kRight, kTop + kRow * (double(arm) + 0.5) - 6, "end", "tick",
                    std::to_string(failed) + " failed") +
           "\n";
  }
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm)
    if (const ArmSummary* one = find(a, arm, t.parts.size() == 1 ? kAllParts : part, metric);
        one && one->seeds > 1)
      s += interval_mark(x, kTop + kRow * (double(arm) + 0.5), std::max(x.low(), one->interval.low),
                         one->mean, std::min(x.high(), one->interval.high), "var(--fg)");
  return s + "</svg>\n";
}

std::string forest_plot(const StudyTable& t, const std::vector<const ArmComparison*>& pairs) {
  std::vector<std::string> rows;
  double reach = 1.0;
  const auto scale = [](const ArmComparison& c) {
    const double larger = std::max(std::abs(c.values.mean_a), std::abs(c.values.mean_b));
    return larger > 0.0 ? 100.0 / larger : 0.0;
  };
  for (const ArmComparison* c : pairs) {
    rows.push_back(t.arms[c->a] + " – " + t.arms[c->b]);
    for (const double v : {c->values.interval.low, c->values.interval.high})
      if (std::isfinite(v)) reach = std::max(reach, std::abs(v) * scale(*c));
  }
  const Axis x(-reach, reach, kPairNames, kRight, 6);
  std::string s = svg_open(660, total_height(rows.size()), "paired differences");
  s += frame(x, kPairNames, rows, "% of the larger mean; left: the first is smaller");
  s += form("<path class=\"axis\" d=\"M%.1f %.1fV%.1f\"/>\n", x.px(0.0), kTop,
            kTop + kRow * double(rows.size()));
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const ArmComparison& c = *pairs[n];
    if (c.any_failed()) {
      const bool right = c.values.difference < 0.0;  // beside the interval
      s +=
          svg_text(right ? kRight : kPairNames + kBeside, kTop + kRow * (double(n) + 0.5) + 4,
                   right ? "end" : "start", "tick", form("failed prints %zu : %zu", c.failed_a, c.failed_b)) +
          "\n";
    }
    if (!std::isfinite(c.values.interval.low)) continue;
    const std::string colour = c.told_apart() ? "var(--c0)" : "var(--soft)";
    s += interval_mark(x, kTop + kRow * (double(n) + 0.5), c.values.interval.low * scale(c),
                       c.values.difference * scale(c), c.values.interval.high * scale(c), colour);
  }
  return s + "</svg>\n";
}

std::string trade_off_plot(const StudyTable& t, const StudyAnalysis& a, std::size_t x_metric,
                           std::size_t y_metric) {
  struct Mark {
    std::size_t arm;
    const ArmSummary *x, *y;
  };
  std::vector<Mark> marks;
  double low = INFINITY, high = 0.0, top = 0.0;
  for (std::size_t arm = 0; arm < t.arms.size(); ++arm) {
    const Mark m{arm, find(a, arm, kAllParts, x_metric), find(a, arm, kAllParts, y_metric)};
    if (!m.x || !m.y || m.x->seeds == 0) continue;
    marks.push_back(m);
    low = std::min(low, m.x->mean);
    high = std::max(high, m.x->mean);
    top = std::max({top, m.y->mean, std::isfinite(m.y->interval.high) ? m.y->interval.high : 0.0});
  }
  if (marks.empty()) return "";
  constexpr double kLeft = 70, kBottom = 320;
  const double room = std::max(0.05 * high, 0.12 * (high - low));
  const Axis x(low - room, high + 2.0 * room, kLeft, kRight, 7), y(0.0, 1.08 * top, kBottom, kTop, 6);
  const auto named = [](const StudyMetric& m) {
    return m.name + (m.unit.empty() ? "" : " [" + m.unit + "]");
  };
  std::string s =
      svg_open(660, kBottom + 50, named(t.metrics[y_metric]) + " against " + named(t.metrics[x_metric]));
  for (const Axis::Tick& tick : x.ticks())
    s += form("<path class=\"grid\" d=\"M%.1f %.1fV%.1f\"/>", x.px(tick.value), kTop, kBottom) +
         svg_text(x.px(tick.value), kBottom + 17, "middle", "tick", tick.text);
  for (const Axis::Tick& tick : y.ticks())
    s += form("<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", kLeft, y.px(tick.value), kRight) +
         svg_text(kLeft - 8, y.px(tick.value) + 4, "end", "tick", tick.text);
  s += svg_text((kLeft + kRight) / 2, kBottom + 38, "middle", "name", named(t.metrics[x_metric]));
  s += form("<g transform=\"translate(16 %.1f) rotate(-90)\">", (kTop + kBottom) / 2) +
       svg_text(0, 0, "middle", "name", named(t.metrics[y_metric])) + "</g>\n";
  std::sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) { return a.x->mean > b.x->mean; });
  std::vector<std::array<double, 3>>
      taken;  // left, right, height of the labels so far: each goes to the free height nearest to its mark
  for (const Mark& m : marks) {
    const double px = x.px(m.x->mean), py = y.px(m.y->mean);
    const std::string label =
        t.arms[m.arm] +
        (a.stopped[m.arm] + a.out[m.arm] ? form(" (%d failed)", a.stopped[m.arm] + a.out[m.arm]) : "");
    constexpr double kCharacter = 6.6, kLine = 14;
    std::array<double, 3> room{px + 8, px + 8 + kCharacter * double(label.size()), py - 7};
    const auto meets = [&](const auto& o) {
      return room[0] < o[1] && o[0] < room[1] && std::abs(room[2] - o[2]) < kLine;
    };
    for (double aside = 0.0; aside < kBottom; aside += 1.0) {
      room[2] = py - 7 - aside;
      if (room[2] > kTop + kLine && std::none_of(taken.begin(), taken.end(), meets)) break;
      room[2] = py - 7 + aside;
      if (room[2] < kBottom - 4 && std::none_of(taken.begin(), taken.end(), meets)) break;
    }
    taken.push_back(room);
    const std::string colour = "var(--c" + std::to_string(m.arm % 6) + ")";
    if (std::isfinite(m.y->interval.low))
      s += form("<path d=\"M%.1f %.1fV%.1f\" stroke-width=\"2\" stroke=\"", px,
                y.px(std::max(0.0, m.y->interval.low)), y.px(m.y->interval.high)) +
           colour + "\"/>";
    if (std::isfinite(m.x->interval.low))
      s += form("<path d=\"M%.1f %.1fH%.1f\" stroke-width=\"2\" stroke=\"", x.px(m.x->interval.low), py,
                x.px(m.x->interval.high)) +
           colour + "\"/>";
    s += form("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\" fill=\"", px, py) + colour + "\"/>" +
         svg_text(room[0], room[2], "start", "tick", label) + "\n";
  }
  return s + "</svg>\n";
}

}  // namespace firn::report
