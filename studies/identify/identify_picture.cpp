// Draws the pictures of `firn identify`.
#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "report/draw/charts.h"
#include "report/draw/svg.h"
#include "studies/identify/identify.h"

namespace firn {
namespace {

using report::svg_text;

struct Way {
  const char* label;
  std::array<double, 3> mean_um, half_um;
};

// 5 x 5 cells with their rise in um, the fuller the higher.
std::string stencil(double left, double top, const droplet::Rise& rise, double highest_mm,
                    const std::string& title) {
  constexpr double kCell = 39;
  std::string s = svg_text(left + 2.5 * kCell, top - 10, "middle", "name", title);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) {
      const double z = rise.mean_mm[4 - y][x];
      const double share = std::clamp(z / highest_mm, 0.0, 1.0);
      s += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" fill=\"var(--c0)\" "
          "fill-opacity=\"{:.3f}\" stroke=\"var(--grid)\"/>",
          left + x * kCell, top + y * kCell, kCell, kCell, 0.55 * share);
      s += svg_text(left + (x + 0.5) * kCell, top + (y + 0.5) * kCell + 4, "middle", "tick",
                    report::number(z * 1e3, 2));
    }
  return s;
}

}  // namespace

std::string identification_svg(const Identification& id) {
  const bool prints = id.prints.complete();
  std::vector<Way> ways;
  const auto um = [](double mm) { return mm * 1e3; };
  ways.push_back({"(3)-(5) fitted to all layers",
                  {um(id.h1.mean_mm), um(id.h2.mean_mm), um(id.h3.mean_mm)},
                  {um(id.h1.half_width_mm), um(id.h2.half_width_mm), um(id.h3.half_width_mm)}});
  if (prints) {
    const auto& p = id.prints;
    ways.push_back({"V-C: height of the centre",
                    {um(p.h1.mean_mm), um(p.h2.mean_mm), um(p.h3.mean_mm)},
                    {um(p.h1.half_width_mm), um(p.h2.half_width_mm), um(p.h3.half_width_mm)}});
    ways.push_back({"beside a single droplet",
                    {um(p.h1.mean_mm), um(p.side.mean_mm), um(p.corner.mean_mm)},
                    {um(p.h1.half_width_mm), um(p.side.half_width_mm), um(p.corner.half_width_mm)}});
  }
  constexpr double kPaper[] = {4.4, 0.6, 0.2};
  const double top = prints ? 275 : 40;
  std::string s = report::svg_open(660, top + 200, "h1, h2, h3 identified");
  if (prints) {
    double highest = 0.0;
    for (const auto& row : id.prints.cross_rise.mean_mm)
      for (const double z : row) highest = std::max(highest, z);
    s += stencil(15, 40, id.prints.single_rise, highest,
                 fmt::format("alone, n = {} [um]", id.prints.single_rise.n));
    s += stencil(230, 40, id.prints.cross_rise, highest,
                 fmt::format("with four sides, n = {}", id.prints.cross_rise.n));
    s += stencil(445, 40, id.prints.pair_rise, highest,
                 fmt::format("with one corner, n = {}", id.prints.pair_rise.n));
  }
  for (int n = 0; n < 3; ++n) {
    double low = kPaper[n], high = kPaper[n];
    for (const Way& w : ways) {
      low = std::min(low, w.mean_um[std::size_t(n)] - w.half_um[std::size_t(n)]);
      high = std::max(high, w.mean_um[std::size_t(n)] + w.half_um[std::size_t(n)]);
    }
    const double pad = 0.1 * (high - low) + 0.01, left = 30.0 + 205 * n;
    const report::Axis x(low - pad, high + pad, left, left + 170, 3);
    const report::Frame frame{left, top, left + 170, top + 100};
    for (const auto& t : x.ticks()) s += svg_text(x.px(t.value), frame.bottom + 17, "middle", "tick", t.text);
    s += fmt::format("<path class=\"axis\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", frame.left, frame.bottom,
                     frame.right);
    s += fmt::format("<path d=\"M{:.1f} {:.1f}V{:.1f}\" stroke=\"var(--soft)\" stroke-dasharray=\"4 3\"/>",
                     x.px(kPaper[n]), frame.top, frame.bottom);
    for (std::size_t w = 0; w < ways.size(); ++w) {
      const double y = frame.top + 20 + 28 * double(w), mean = ways[w].mean_um[std::size_t(n)],
                   half = ways[w].half_um[std::size_t(n)];
      s += fmt::format(
          "<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"var(--c{})\" stroke-width=\"2\"/><circle cx=\"{:.1f}\" "
          "cy=\"{:.1f}\" r=\"4\" fill=\"var(--c{})\"/>",
          x.px(mean - half), y, x.px(mean + half), w, x.px(mean), y, w);
    }
    s += svg_text(left + 85, frame.bottom + 34, "middle", "name", fmt::format("h{} [um]", n + 1));
  }
  double at = 30;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    s += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"var(--c{})\"/>", at, top + 160, w);
    s += svg_text(at + 9, top + 164, "start", "tick", ways[w].label);
    at += 205;
  }
  s += svg_text(30, top + 184, "start", "tick", "dashed: Lu 2015, Table I; bars: 95 % intervals");
  return s + "</svg>";
}

std::string spacing_svg(const std::vector<droplet::SpacingResult>& results,
                        const droplet::SpacingChoice& choice) {
  report::Series all{"inconsistency", {}, {}, 0, true}, sizes{"between sizes of squares", {}, {}, 1, true},
      inside{"within a square", {}, {}, 2, true};
  for (const auto& r : results) {
    for (auto* s : {&all, &sizes, &inside}) s->x.push_back(r.gamma);
    all.y.push_back(100 * r.inconsistency);
    sizes.y.push_back(100 * r.between_sizes);
    inside.y.push_back(100 * r.within);
  }
  report::ChartOptions o;
  o.title = fmt::format("Height of n x n squares by spacing; chosen: gamma = {:.3f}", choice.gamma);
  o.x_name = "gamma = spacing / droplet diameter";
  o.y_name = "relative standard deviation [%]";
  o.from_zero = true;
  return report::line_chart({all, sizes, inside}, o);
}

}  // namespace firn
