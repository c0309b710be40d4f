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

OneLayer decide_one_layer(const Setup& setup, const HeightMap& height, const DropletPattern& guess,
                          MpcMethod method, int strip_rows, const ParallelFor& parallel) {
  constexpr int kMaxSweeps = 200;
  OneLayer out;
  {
    LayerProblem problem(setup, height, {});
    problem.set_drops(guess);
    if (method == MpcMethod::kCertified) {
      out.strips =
          solve_layer(problem, {2, 2, std::size_t(problem.counted()) <= kMaxSplitCells ? 1 : 0, 1e-6},
                      parallel)
              .strips;
    } else {
      for (int rows = std::min(2, strip_rows); rows <= strip_rows; ++rows) {
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
