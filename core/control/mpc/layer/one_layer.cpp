#include "core/control/mpc/layer/one_layer.h"

#include <algorithm>
#include <cmath>

#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "core/deposition/height_change.h"

namespace firn::control::mpc {

double mean_error_mm(const Setup& s, const HeightMap& height, const DropletPattern& drops) {
  constexpr int kRows = 64;  // at a time; beside them one row on each side, whose droplets reach in
  const int nx = s.grid.nx, ny = s.grid.ny;
  double sum = 0.0, cells = 0.0;
  for (int first = 0; first < ny; first += kRows) {
    const int from = std::max(0, first - 1), to = std::min(ny, first + kRows + 1);
    GridSpec band = s.grid;
    band.ny = to - from;
    HeightMap after(band);
    const std::size_t begin = s.grid.index(0, from);
    std::copy_n(height.data() + begin, band.size(), after.data());
    deposition::HeightChange<1> model(band, deposition::stencil_of(s.model), s.border);
    model.step(after.data(), drops.data() + begin, 0);
    for (int j = first; j < std::min(ny, first + kRows); ++j)
      for (int i = 0; i < nx; ++i) {
        if (!s.mask.at(i, j)) continue;
        sum += std::abs(s.target.at(i, j) - after.at(i, j - from));
        cells += 1.0;
      }
  }
  return sum / cells;
}

double outside_rise_mm(const Setup& s, const HeightMap& height, const DropletPattern& drops) {
  const std::vector<deposition::Link> links = deposition::links_of(deposition::stencil_of(s.model));
  double sum = 0.0;
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i < s.grid.nx; ++i) {
      if (!drops.at(i, j)) continue;
      for (const deposition::Link& link : links) {
        const int x = i + link.dx, y = j + link.dy;
        if (!s.grid.contains(x, y))
          sum += s.border == deposition::Border::kLose ? link.w_mm : 0.0;
        else if (!s.mask.at(x, y))
          sum += link.spread_mm(height.at(i, j) - height.at(x, y));
      }
    }
  return sum;
}

LayerSolverOptions certified_options(const MpcOptions& options) {
  constexpr int kSweepsForGap = 100;  // the bound has converged by then (dual_decomposition.h)
  constexpr double kOptimal = 1e-6;   // of the objective: rounding in single precision
  constexpr int kRows = 2;            // of the strips that find the layer, and of those that bound it
  CellCost cost;
  cost.outside = float(options.outside_price);
  if (options.gap > 0.0) return {kRows, kRows, std::max(options.sweeps, kSweepsForGap), options.gap, cost};
  return {kRows, kRows, options.sweeps, kOptimal, cost};
}

std::string reached(const MpcOptions& options, const LayerSolution& s) {
  if (options.sweeps == 1 && options.gap == 0.0) return "";
  if (s.sweeps == 0 || !(s.found_mm > 0.0)) return "; strips alone, without a bound";
  const double gap = std::max(0.0, 1.0 - s.lower_bound_mm / s.found_mm);
  return "; after " + std::to_string(s.sweeps) + (s.sweeps == 1 ? " sweep" : " sweeps") +
         ", no layer is better by more than " + std::to_string(100.0 * gap) + " %";
}

OneLayer decide_one_layer(const Setup& setup, const HeightMap& height, const DropletPattern& guess,
                          const MpcOptions& options, const ParallelFor& parallel) {
  constexpr int kMaxSweeps = 200;
  OneLayer out;
  std::int64_t counted = 0;
  {
    CellCost cost;
    cost.outside = float(options.outside_price);
    LayerProblem problem(setup, height, {});
    counted = problem.counted();
    problem.set_drops(guess);
    if (options.method == MpcMethod::kCertified && std::size_t(problem.counted()) <= kMaxSplitCells) {
      out.certified = solve_layer(problem, certified_options(options), parallel);
      out.strips = out.certified.strips;
    } else {
      for (int rows = std::min(2, options.strip_rows); rows <= options.strip_rows; ++rows) {
        const StripResult r = sweep_strips(problem, {rows, kMaxSweeps, cost}, parallel);
        out.strips += r.strips;
        out.settled = r.settled;
      }
    }
    out.drops = problem.drops(setup.grid);
  }
  out.objective_mm = mean_error_mm(setup, height, out.drops);
  if (options.outside_price > 0.0)
    out.objective_mm += options.outside_price * outside_rise_mm(setup, height, out.drops) / double(counted);
  return out;
}

}  // namespace firn::control::mpc
