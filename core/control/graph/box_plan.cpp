#include "core/control/graph/box_plan.h"

#include <algorithm>
#include <cmath>

namespace firn::control::graph {
namespace {

constexpr int kOverlap = 2;          // cells by which a block is larger than its tile, at each side
constexpr double kInnerShare = 0.1;  // tolerance of a block's own solution by that of the whole

std::span<const double> layer_of(std::span<const double> doses, std::size_t layer, std::size_t cells) {
  return doses.subspan(layer * cells, cells);
}

// A'(counts e), layer by layer.
void gradient(const BoxProblem& p, std::span<const double> error, std::vector<double>& by_dose) {
  std::vector<double> lambda(p.cells());
  for (std::size_t c = 0; c < lambda.size(); ++c) lambda[c] = p.counts[c] ? error[c] : 0.0;
  for (std::size_t n = p.layers.size(); n-- > 0;)
    p.layers[n].transposed(lambda, std::span(by_dose).subspan(n * p.cells(), p.cells()));
}

// Bound of the largest eigenvalue of A'A: of a matrix without negative entries the largest sum of a row times
// that of a column.
double bound_mm2(const BoxProblem& p) {
  const std::vector<double> rows = p.change(std::vector<double>(p.unknowns(), 1.0));
  std::vector<double> columns(p.unknowns());
  gradient(p, std::vector<double>(p.cells(), 1.0), columns);
  double row = 0.0, column = 0.0;
  for (std::size_t c = 0; c < rows.size(); ++c)
    if (p.counts[c]) row = std::max(row, rows[c]);
  for (const double sum : columns) column = std::max(column, sum);
  return row * column;
}

struct Block {
  Window window;              // of the problem, with the cells that its doses reach
  BoxProblem problem;         // wanted_mm is set in each iteration
  std::vector<double> doses;  // found
};

template <class T>
std::vector<T> cut(const std::vector<T>& from, const Window& w, int nx, std::size_t offset = 0) {
  std::vector<T> to;
  to.reserve(w.size());
  for (int j = w.j0; j < w.j1; ++j)
    for (int i = w.i0; i < w.i1; ++i)
      to.push_back(from[offset + std::size_t(j) * std::size_t(nx) + std::size_t(i)]);
  return to;
}

std::vector<Block> blocks_of(const BoxProblem& p) {
  const int reach = p.reach(), side = 2 * reach + 2 * kOverlap + 1;
  std::vector<Block> blocks;
  for (int j = 0; j < p.ny; j += side)
    for (int i = 0; i < p.nx; i += side) {
      const Window own =
          Window{i, std::min(p.nx, i + side), j, std::min(p.ny, j + side)}.grown(kOverlap, p.nx, p.ny);
      const Window seen = own.grown(reach, p.nx, p.ny);
      Block b{seen, {}, {}};
      b.problem.nx = seen.nx();
      b.problem.ny = seen.ny();
      b.problem.effort_mm2 = p.effort_mm2;
      b.problem.counts = cut(p.counts, seen, p.nx);
      b.problem.free.assign(seen.size(), 0);
      bool any = false;
      for (int y = own.j0; y < own.j1; ++y)
        for (int x = own.i0; x < own.i1; ++x) {
          const std::uint8_t free = p.free[std::size_t(y) * std::size_t(p.nx) + std::size_t(x)];
          b.problem.free[std::size_t(y - seen.j0) * std::size_t(seen.nx()) + std::size_t(x - seen.i0)] = free;
          any = any || free;
        }
      if (!any) continue;
      for (const AffineLayer& layer : p.layers) b.problem.layers.push_back(layer.on(seen));
      blocks.push_back(std::move(b));
    }
  return blocks;
}

}  // namespace

std::vector<double> BoxProblem::change(std::span<const double> doses) const {
  std::vector<double> z(cells(), 0.0);
  for (std::size_t n = 0; n < layers.size(); ++n) layers[n].change(z, layer_of(doses, n, cells()));
  return z;
}

double BoxProblem::cost_mm2(std::span<const double> doses) const {
  const std::vector<double> z = change(doses);
  double cost = 0.0;
  for (std::size_t c = 0; c < z.size(); ++c)
    if (counts[c]) cost += (wanted_mm[c] - z[c]) * (wanted_mm[c] - z[c]);
  for (const double u : doses) cost += effort_mm2 * u * u;
  return cost;
}

int BoxProblem::reach() const {
  int cells = 0;
  for (const AffineLayer& layer : layers) cells += layer.reach();
  return cells;
}

BoxSolution solve_together(const BoxProblem& p, std::vector<double> u, const BoxLimits& limits) {
  const double largest = bound_mm2(p) + p.effort_mm2, root = std::sqrt(p.effort_mm2 / largest);
  const double momentum = (1.0 - root) / (1.0 + root);
  const std::size_t cells = p.cells();
  for (std::size_t n = 0; n < u.size(); ++n) u[n] = p.free[n % cells] ? std::clamp(u[n], 0.0, 1.0) : 0.0;
  std::vector<double> ahead = u, by_dose(u.size());
  BoxSolution s;
  while (s.iterations < limits.iterations) {
    ++s.iterations;
    std::vector<double> error = p.change(ahead);
    for (std::size_t c = 0; c < cells; ++c) error[c] -= p.wanted_mm[c];
    gradient(p, error, by_dose);
    double change = 0.0;
    for (std::size_t n = 0; n < u.size(); ++n) {
      if (!p.free[n % cells]) continue;
      const double next = std::clamp(ahead[n] - (by_dose[n] + p.effort_mm2 * ahead[n]) / largest, 0.0, 1.0);
      change = std::max(change, std::abs(next - ahead[n]));
      ahead[n] = next + momentum * (next - u[n]);
      u[n] = next;
    }
    // A gradient step of length d is at most d L / effort away; momentum walks that way in sqrt(L / effort).
    if (change < limits.tolerance * root) break;
  }
  s.doses = std::move(u);
  return s;
}

BoxSolution solve_in_blocks(const BoxProblem& p, std::vector<double> u, const BoxLimits& limits,
                            const ParallelFor& parallel) {
  const std::size_t cells = p.cells();
  for (std::size_t n = 0; n < u.size(); ++n) u[n] = p.free[n % cells] ? std::clamp(u[n], 0.0, 1.0) : 0.0;
  std::vector<Block> blocks = blocks_of(p);
  BoxSolution s;
  while (s.iterations < limits.iterations) {
    ++s.iterations;
    std::vector<double> left = p.change(u);
    for (std::size_t c = 0; c < cells; ++c) left[c] = p.wanted_mm[c] - left[c];
    parallel(int(blocks.size()), [&](int n) {
      Block& b = blocks[std::size_t(n)];
      b.doses.clear();
      for (std::size_t layer = 0; layer < p.layers.size(); ++layer) {
        const std::vector<double> now = cut(u, b.window, p.nx, layer * cells);
        for (std::size_t c = 0; c < now.size(); ++c) b.doses.push_back(b.problem.free[c] ? now[c] : 0.0);
      }
      b.problem.wanted_mm = cut(left, b.window, p.nx);
      const std::vector<double> own = b.problem.change(b.doses);
      for (std::size_t c = 0; c < own.size(); ++c) b.problem.wanted_mm[c] += own[c];
      b.doses =
          solve_together(b.problem, std::move(b.doses), {kInnerShare * limits.tolerance, limits.iterations})
              .doses;
    });
    std::vector<double> step(u.size(), 0.0);
    for (const Block& b : blocks)
      for (std::size_t layer = 0; layer < p.layers.size(); ++layer)
        for (int j = b.window.j0; j < b.window.j1; ++j)
          for (int i = b.window.i0; i < b.window.i1; ++i) {
            const std::size_t here =
                std::size_t(j - b.window.j0) * std::size_t(b.window.nx()) + std::size_t(i - b.window.i0);
            if (!b.problem.free[here]) continue;
            const std::size_t n = layer * cells + std::size_t(j) * std::size_t(p.nx) + std::size_t(i);
            step[n] += 0.25 * (b.doses[layer * b.window.size() + here] - u[n]);
          }
    double change = 0.0;
    for (std::size_t n = 0; n < u.size(); ++n) {
      u[n] += step[n];
      change = std::max(change, std::abs(step[n]));
    }
    if (change < limits.tolerance) break;
  }
  s.doses = std::move(u);
  return s;
}

}  // namespace firn::control::graph
