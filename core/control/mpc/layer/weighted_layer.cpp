#include "core/control/mpc/layer/weighted_layer.h"

#include <algorithm>
#include <cmath>

#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/strip_dp.h"

namespace firn::control::mpc {
namespace {

constexpr double kMinDeviation_mm = 1e-6;  // the majoriser's slope at a flat surface
constexpr double kMinImprovement_mm = 1e-10;

double objective(const ErrorMoments& m, double alpha) {
  return alpha * m.absolute_mm + (1.0 - alpha) * m.deviation_mm;
}

// Lowers the objective from the present droplets.
double lower(LayerProblem& p, double alpha, const WeightedOptions& o, const ParallelFor& parallel) {
  ErrorMoments now = error_moments(p);
  for (int round = 0; round < o.rounds; ++round) {
    const double square = 0.5 * (1.0 - alpha) / std::max(now.deviation_mm, kMinDeviation_mm);
    const CellCost cost{float(alpha), float(-2.0 * square * now.mean_mm), float(square)};
    LayerProblem next = p;
    for (int rows = 2; rows <= std::max(2, o.strip_rows); ++rows)
      sweep_strips(next, {rows, 100, cost}, parallel);
    next.refresh();
    const ErrorMoments then = error_moments(next);
    if (!(objective(then, alpha) < objective(now, alpha) - kMinImprovement_mm)) break;
    p = std::move(next);
    now = then;
  }
  return objective(now, alpha);
}

}  // namespace

ErrorMoments error_moments(const LayerProblem& p) {
  ErrorMoments m;
  const double n = double(p.counted());
  double sum = 0.0, square = 0.0;
  for (int j = 0; j < p.ny(); ++j)
    for (int i = 0; i < p.nx(); ++i)
      if (p.printable(i, j)) {
        m.absolute_mm += std::abs(double(p.error_mm(i, j)));
        sum += double(p.error_mm(i, j));
      }
  m.mean_mm = sum / n;
  for (int j = 0; j < p.ny(); ++j)
    for (int i = 0; i < p.nx(); ++i)
      if (p.printable(i, j)) {
        const double d = double(p.error_mm(i, j)) - m.mean_mm;
        square += d * d;
      }
  m.absolute_mm /= n;
  m.deviation_mm = std::sqrt(square / n);
  return m;
}

double weighted_objective_mm(const LayerProblem& problem, double alpha) {
  return objective(error_moments(problem), alpha);
}

double weighted_layer(LayerProblem& problem, double alpha, const WeightedOptions& o,
                      const ParallelFor& parallel) {
  LayerProblem none = problem, all = problem, absolute = problem;
  none.clear();
  for (int j = 0; j < all.ny(); ++j)
    for (int i = 0; i < all.nx(); ++i) all.set_drop(i, j, all.printable(i, j));
  all.refresh();
  solve_layer(absolute, {2, 1, 1, 1e-6}, parallel);
  double best = lower(problem, alpha, o, parallel);
  for (LayerProblem* start : {&none, &all, &absolute}) {
    const double found = lower(*start, alpha, o, parallel);
    if (!(found < best)) continue;
    best = found;
    problem = std::move(*start);
  }
  return best;
}

}  // namespace firn::control::mpc
