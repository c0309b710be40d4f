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

LayerSolverOptions certified_options(const MpcOptions& options, std::int64_t counted) {
  constexpr int kSweepsForGap = 100;  // the bound has converged by then (dual_decomposition.h)
  constexpr double kOptimal = 1e-6;   // of the objective: rounding in single precision
  constexpr int kRows = 2;            // of the strips that find the layer, and of those that bound it
  if (std::size_t(counted) > kMaxSplitCells) return {kRows, kRows, 0, kOptimal};
  if (options.gap > 0.0) return {kRows, kRows, std::max(options.sweeps, kSweepsForGap), options.gap};
  return {kRows, kRows, options.sweeps, kOptimal};
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
  {
    LayerProblem problem(setup, height, {});
    problem.set_drops(guess);
    if (options.method == MpcMethod::kCertified) {
      out.certified = solve_layer(problem, certified_options(options, problem.counted()), parallel);
      out.strips = out.certified.strips;
    } else {
      for (int rows = std::min(2, options.strip_rows); rows <= options.strip_rows; ++rows) {
        const StripResult r = sweep_strips(problem, {rows, kMaxSweeps}, parallel);
        out.strips += r.strips;
        out.settled = r.settled;
      }
    }
    out.drops = problem.drops(setup.grid);
  }
  out.objective_mm = mean_error_mm(setup, height, out.drops);
  return out;
}

}  // namespace firn::control::mpc
