// GraphLayer computes the heights after a layer by flow along the edges of a graph whose nodes are cells, and
// the affine form of it about a plan, which predictive control needs.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/grid.h"

namespace firn::control::graph {

/// Structure after Y. Guo, J. Peters, T. Oomen, S. Mishra, "Control-oriented models for ink-jet 3D printing",
/// Mechatronics 56 (2018) 211, of which the abstract alone was read; the equations are ours. A droplet lands
/// on its cell: v = B u. Then in each of `steps` steps wet ink v flows along the edges to the side and corner
/// neighbours (D: incidence matrix, H: cured height),
///   q = K sat(D'(H + v)),      v <- v - D q,
/// q lessened so that v >= 0, and H + v is the height after the layer. Columns of D sum to 0, so that volume
/// is conserved.
///
/// B = V = h1 + 4 h2 + 4 h3, K = h2 / V at a side and h3 / V at a corner, sat within +-V: in one step a
/// single droplet on level ground then has exactly the heights h1, h2, h3 of the identified model. With
/// several steps each has its part of K. Beyond the grid's border the ground is infinitely low or a wall
/// (deposition::Border).
struct GraphModel {
  GraphModel() = default;
  /// @param steps 1 or more
  GraphModel(const deposition::DropletModel& model, deposition::Border border, int steps);
  double droplet_mm = 0.0;          ///< V
  double side = 0.0, corner = 0.0;  ///< K, of one step
  int steps = 1;
  deposition::Border border = deposition::Border::kLose;
};

/// Neighbours that own an edge: each pair of cells is named once.
inline constexpr std::array<std::array<int, 2>, 4> kEdges{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};

/// A part of a grid: cells [i0, i1) x [j0, j1).
struct Window {
  int i0 = 0, i1 = 0, j0 = 0, j1 = 0;
  int nx() const { return i1 - i0; }
  int ny() const { return j1 - j0; }
  std::size_t size() const { return std::size_t(nx()) * std::size_t(ny()); }
  /// Cells within `by` of it, as far as there are cells.
  Window grown(int by, int nx, int ny) const;
};

/// Heights after one layer: z = H + B u, then in each step z <- z - D (k D'z + a), with k and a of each edge
/// as they are along a plan. Saturated edges have k = 0; those of a node that has less wet ink than its edges
/// ask for are lessened alike. With 0 <= k and a sum of k of at most 1 at each node no entry of the matrix is
/// negative.
class AffineLayer {
 public:
  /// Adds what u changes: z += M B u, heights in place. @param dose droplets per cell
  void change(std::span<double> height_mm, std::span<const double> dose) const;
  /// The heights after the layer, with the constant flow.
  void apply(std::span<double> height_mm, std::span<const double> dose) const;
  /// Transposed: lambda <- M' lambda, and the gradient by the dose, B' M' lambda, into `by_dose`.
  void transposed(std::span<double> lambda, std::span<double> by_dose) const;
  /// The same layer on a part of the grid, whose border lets nothing through: exact for changes that do not
  /// reach the border.
  AffineLayer on(const Window& window) const;
  int reach() const { return int(steps_.size()); }  ///< cells that a dose changes, at each side

 private:
  friend AffineLayer layer_along(const GraphModel&, const GridSpec&, std::span<const double> droplet_mm,
                                 std::vector<double>&, std::span<const double>);
  struct Step {
    std::array<std::vector<double>, 4> k;  ///< of kEdges, cell by cell
    std::vector<double> constant_mm;       ///< -D a, and what leaves over the border
  };
  void flow(std::span<double> height_mm, const Step& step, bool with_constant) const;

  int nx_ = 0, ny_ = 0;
  std::vector<double> droplet_mm_;  ///< B of each cell
  std::vector<Step> steps_;
};

/// Deposits a layer by the model with all its limits, in place, and returns its affine form about this dose.
/// @param droplet_mm V of each cell's ink @param dose droplets per cell, 0 or more
/// @pre sizes equal to the grid's; heights finite
AffineLayer layer_along(const GraphModel& model, const GridSpec& grid, std::span<const double> droplet_mm,
                        std::vector<double>& height_mm, std::span<const double> dose);

}  // namespace firn::control::graph
