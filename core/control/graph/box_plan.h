// Solves the plan of several layers as a quadratic programme in a box: all cells together, or block by block.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/control/graph/graph_layer.h"
#include "core/grid/parallel.h"

namespace firn::control::graph {

/// min over u of |r - A u|^2 over the cells that count + effort |u|^2, 0 <= u <= 1 on the cells that may get
/// droplets and u = 0 elsewhere. A is the change of the heights after the last layer by the doses of all
/// layers. effort > 0 makes the minimum unique.
struct BoxProblem {
  int nx = 0, ny = 0;
  std::vector<AffineLayer> layers;         ///< of A, first to last
  std::vector<double> wanted_mm;           ///< r: change of the height after the last layer
  std::vector<std::uint8_t> counts, free;  ///< cells
  double effort_mm2 = 0.0;

  std::size_t cells() const { return std::size_t(nx) * std::size_t(ny); }
  std::size_t unknowns() const { return layers.size() * cells(); }
  /// A u. @param doses layer by layer, cell by cell
  std::vector<double> change(std::span<const double> doses) const;
  double cost_mm2(std::span<const double> doses) const;
  int reach() const;  ///< cells that a dose changes, at each side
};

struct BoxSolution {
  std::vector<double> doses;  ///< layer by layer, cell by cell
  int iterations = 0;
};

struct BoxLimits {
  double tolerance = 1e-4;  ///< largest change of a dose in an iteration
  int iterations = 5000;
};

/// By projected gradients with constant momentum [Nesterov, Introductory Lectures on Convex Optimization,
/// 2004, 2.2.4], which falls by 1 - sqrt(effort / L) each. L is the product of the largest sums of a row and
/// of a column of A, whose entries are not negative, plus the effort.
BoxSolution solve_together(const BoxProblem& problem, std::vector<double> start, const BoxLimits& limits);

/// Block Jacobi: blocks of cells that overlap each minimise the cost over their own doses, those of all
/// others held; each dose goes a quarter of the way that each block of it asks for. Blocks have four colours,
/// and those of one colour do not see each other, so that a step is the mean of four that lessen a convex
/// cost: it converges to solve_together()'s minimum. The result has the same bytes for any number of threads.
BoxSolution solve_in_blocks(const BoxProblem& problem, std::vector<double> start, const BoxLimits& limits,
                            const ParallelFor& parallel);

}  // namespace firn::control::graph
