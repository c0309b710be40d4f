#include "core/control/mpc/layer/layer_solver.h"

#include <algorithm>
#include <cmath>

#include "core/control/mpc/layer/strip_dp.h"

namespace firn::control::mpc {
namespace {

constexpr int kMaxSweeps = 200;
constexpr double kMinGain_mm = 1e-8;

std::int64_t polish(LayerProblem& problem, const LayerSolverOptions& o, const ParallelFor& parallel) {
  std::int64_t strips = 0;
  for (int k = 2; k <= std::max(2, o.polish_rows); ++k)
    strips += sweep_strips(problem, {k, kMaxSweeps, o.cost}, parallel).strips;
  problem.refresh();
  return strips;
}

}  // namespace

int take_better_patches(LayerProblem& layer, const LayerProblem& other, const CellCost& cost) {
  const int nx = layer.nx(), ny = layer.ny();
  const auto differs = [&](int i, int j) { return layer.drop(i, j) != other.drop(i, j); };
  struct Cell {
    int i, j;
  };
  std::vector<std::uint8_t> seen(std::size_t(nx) * std::size_t(ny), 0), judged(seen);
  std::vector<Cell> patch;
  const LayerProblem before = layer;
  int taken = 0;
  for (int j0 = 0; j0 < ny; ++j0)
    for (int i0 = 0; i0 < nx; ++i0) {
      const auto visit = [&](int i, int j) {
        std::uint8_t& s = seen[std::size_t(j) * std::size_t(nx) + std::size_t(i)];
        if (s || before.drop(i, j) == other.drop(i, j)) return;
        s = 1;
        patch.push_back({i, j});
      };
      if (seen[std::size_t(j0) * std::size_t(nx) + std::size_t(i0)] || !differs(i0, j0)) continue;
      patch.clear();
      visit(i0, j0);
      const auto around = [&](Cell c, int reach, const auto& body) {
        for (int j = std::max(0, c.j - reach); j <= std::min(ny - 1, c.j + reach); ++j)
          for (int i = std::max(0, c.i - reach); i <= std::min(nx - 1, c.i + reach); ++i) body(i, j);
      };
      for (std::size_t n = 0; n < patch.size(); ++n)
        around(patch[n], 2, visit);  // cells of one error belong together
      double gain = 0.0;
      for (const Cell c : patch) {
        if (cost.outside > 0.0f)
          gain += (before.drop(c.i, c.j) ? 1.0 : -1.0) * double(cost.outside) *
                  double(before.outside_mm(c.i, c.j));
        around(c, 1, [&](int i, int j) {
          std::uint8_t& done = judged[std::size_t(j) * std::size_t(nx) + std::size_t(i)];
          if (done) return;
          done = 1;
          gain += cost_of(cost, double(before.error_mm(i, j))) - cost_of(cost, double(other.error_mm(i, j)));
        });
      }
      if (!(gain > kMinGain_mm)) continue;
      ++taken;
      for (const Cell c : patch) layer.set_drop(c.i, c.j, other.drop(c.i, c.j));
    }
  return taken;
}

double total_cost(const LayerProblem& layer, const CellCost& cost) {
  double sum = 0.0;
  for (int j = 0; j < layer.ny(); ++j) {
    const float* e = layer.error_row(j);
    for (int i = 0; i < layer.nx(); ++i) {
      sum += cost_of(cost, double(e[i]));
      if (cost.outside > 0.0f && layer.drop(i, j))
        sum += double(cost.outside) * double(layer.outside_mm(i, j));
    }
  }
  return sum;
}

LayerSolution solve_layer(LayerProblem& problem, const LayerSolverOptions& o, const ParallelFor& parallel,
                          const std::function<void(const LayerSolution&)>& watch) {
  LayerSolution s;
  s.strips = polish(problem, o, parallel);
  s.found_mm = total_cost(problem, o.cost);
  if (watch) watch(s);
  if (o.sweeps <= 0) return s;
  DualDecomposition split(problem, o.bound_rows, o.cost);
  LayerProblem other = problem;
  while (s.sweeps < o.sweeps) {
    const SweepDirection direction = s.sweeps % 2 == 0 ? SweepDirection::kDown : SweepDirection::kUp;
    const double bound = split.sweep(direction, parallel);
    s.lower_bound_mm = s.sweeps == 0 ? bound : std::max(s.lower_bound_mm, bound);
    ++s.sweeps;
    if (watch) watch(s);
    if (s.found_mm - s.lower_bound_mm <= o.gap * std::abs(s.found_mm)) break;
    split.decide(direction == SweepDirection::kDown ? SweepDirection::kUp : SweepDirection::kDown, other);
    s.strips += polish(other, o, parallel);
    if (take_better_patches(problem, other, o.cost) > 0) s.strips += polish(problem, o, parallel);
    s.found_mm = total_cost(problem, o.cost);
    if (watch) watch(s);
  }
  return s;
}

}  // namespace firn::control::mpc
