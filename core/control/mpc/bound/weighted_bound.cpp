#include "core/control/mpc/bound/weighted_bound.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "core/control/mpc/bound/bound_checker.h"
#include "core/control/mpc/layer/weighted_layer.h"

namespace firn::control::mpc {
namespace {

constexpr double kMinDeviation_mm = 1e-5;  // a cut's square stays finite
constexpr int kMaxRectangles = 2'000'000;

struct Rectangle {
  double m0, m1, s0, s1, bound;
  bool operator<(const Rectangle& o) const { return bound > o.bound; }  // the least on top
};

double value(const MomentCut& c, double alpha, double m, double s) {
  return c.base + c.slope_m * m - c.square * (m * m + s * s) + (1.0 - alpha) * s;
}

double largest(const std::vector<MomentCut>& cuts, double alpha, double m, double s) {
  double most = alpha * std::abs(m) + (1.0 - alpha) * s;
  for (const MomentCut& c : cuts) most = std::max(most, value(c, alpha, m, s));
  return most;
}

double min_in(const std::vector<MomentCut>& cuts, double alpha, const Rectangle& r) {
  const double nearest = std::clamp(0.0, r.m0, r.m1);
  double most = alpha * std::abs(nearest) + (1.0 - alpha) * r.s0;
  for (const MomentCut& c : cuts) {
    const auto of_m = [&](double m) { return c.slope_m * m - c.square * m * m; };
    const auto of_s = [&](double s) { return (1.0 - alpha) * s - c.square * s * s; };
    most = std::max(most, c.base + std::min(of_m(r.m0), of_m(r.m1)) + std::min(of_s(r.s0), of_s(r.s1)));
  }
  return most;
}

}  // namespace

CutsMinimum minimum_of_cuts(const std::vector<MomentCut>& cuts, double alpha, double known_mm,
                            double tolerance_mm) {
  const double max_m = known_mm / alpha, max_s = known_mm / (1.0 - alpha);
  std::priority_queue<Rectangle> open;
  const auto add = [&](double m0, double m1, double s0, double s1) {
    Rectangle r{m0, m1, s0, s1, 0.0};
    r.bound = min_in(cuts, alpha, r);
    open.push(r);
  };
  add(-max_m, max_m, 0.0, max_s);
  for (int n = 0;; ++n) {
    const Rectangle r = open.top();
    const double m = 0.5 * (r.m0 + r.m1), s = 0.5 * (r.s0 + r.s1);
    if (n >= kMaxRectangles || largest(cuts, alpha, m, s) - r.bound <= tolerance_mm)
      return {std::min(known_mm, r.bound), m, s};
    open.pop();
    if (r.m1 - r.m0 > r.s1 - r.s0) {
      add(r.m0, m, r.s0, r.s1);
      add(m, r.m1, r.s0, r.s1);
    } else {
      add(r.m0, r.m1, r.s0, s);
      add(r.m0, r.m1, s, r.s1);
    }
  }
}

WeightedBound weighted_bound(const Setup& setup, const HeightMap& height, const MaterialMap& materials,
                             double alpha, const DropletPattern& known, const WeightedBoundOptions& o,
                             const ParallelFor& parallel, const std::function<void(double)>& watch) {
  LayerProblem problem(setup, height, materials);
  problem.set_drops(known);
  problem.refresh();
  const ErrorMoments start = error_moments(problem);
  DualDecomposition split(problem, o.strips.rows);
  const double cells = double(problem.counted());
  const float absolute = std::nextafter(float(alpha), 0.0f);  // never more than alpha: |e| >= 0
  WeightedBound found;
  found.known_mm = weighted_objective_mm(problem, alpha);
  const double tolerance_mm = 0.05 * o.gap * found.known_mm;
  std::vector<MomentCut> cuts;
  CutsMinimum least{0.0, start.mean_mm, start.deviation_mm};
  while (found.cuts < o.cuts && found.known_mm - least.bound_mm > o.gap * found.known_mm) {
    const double square = 0.5 * (1.0 - alpha) / std::max(least.deviation_mm, kMinDeviation_mm);
    const CellCost cost{absolute, float(-2.0 * square * least.mean_mm), float(square)};
    split.set_cost(cost);
    found.sweeps += int(raise_bound(split, 0.0, o.strips, parallel).size());
    const double sum_mm =
        certified_bound_mm(setup, height, materials, o.strips.rows, split.multipliers(), cost);
    cuts.push_back({sum_mm / cells, -double(cost.linear), double(cost.square)});
    ++found.cuts;
    const bool useless = found.cuts > 1 && value(cuts.back(), alpha, least.mean_mm, least.deviation_mm) <=
                                               least.bound_mm + 2.0 * tolerance_mm;
    least = minimum_of_cuts(cuts, alpha, found.known_mm, tolerance_mm);
    found.history_mm.push_back(least.bound_mm);
    if (watch) watch(least.bound_mm);
    if (useless) break;
  }
  found.objective_mm = least.bound_mm;
  return found;
}

}  // namespace firn::control::mpc
