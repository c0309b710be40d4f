// The surface between two measurements: predicted droplet by droplet with the height-change model
// [Lu 2015, Eqs. (3)-(5)], corrected by each map, with a variance per cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/grid.h"
#include "estimators/droplet/expected_spread.h"

namespace firn::droplet {

/// One pass: the cells that fired, and which share of them the device counted (1: all).
struct Pass {
  std::vector<std::uint32_t> cells;
  double share = 1.0;
};

/// What a map says of a cell.
enum class Use : std::uint8_t {
  kNothing,  ///< not measured: the prediction stands
  kLearn,    ///< measured: corrects the surface, and what it differs from the prediction is learned from
  kAnchor,   ///< measured, but what fired near it is in doubt: replaces the surface, teaches nothing
};

/// Passes of a layer, the map after it, and what the filter has fixed for it at the last reference().
struct Layer {
  std::vector<Pass> passes;
  std::vector<double> height_mm;
  std::vector<Use> use;
  double noise_variance_mm2 = 0.0;
  // by reference():
  std::vector<std::vector<double>> variance_mm2;  ///< of the surface before each pass
  std::vector<double> gain;                       ///< of the correction, per cell
  std::vector<double> weight;       ///< 1 / variance of the difference, 0 where not learned from
  std::vector<double> scatter_mm2;  ///< variance by droplets of relative scatter 1
};

struct Surface {
  std::vector<double> height_mm, variance_mm2;
};

/// Droplets' relative standard deviation is `scatter`; the measurement's noise is white. The covariance
/// between cells is left out: it costs some precision of the weights, but no bias, for each difference is
/// taken against a prediction made from the past alone.
class SurfaceFilter {
 public:
  SurfaceFilter(const GridSpec& grid, deposition::Border border);

  /// The bare ground: a plane through the map plus what the map's spread leaves beyond its noise.
  /// @param use kNothing where the map does not count
  Surface ground(std::span<const double> height_mm, std::span<const Use> use,
                 double noise_variance_mm2) const;

  /// One layer at `model`: fixes the layer's variances, gains and weights, and moves `surface` past it.
  void reference(Layer& layer, Surface& surface, const deposition::DropletModel& model, double scatter);

  /// The first half of reference(): `surface` after the layer's passes as the model has it, variances with
  /// what droplets scatter.
  void predict(Layer& layer, Surface& surface, const deposition::DropletModel& model, double scatter);

  /// The same with what reference() fixed: moves the heights alone and writes measured - predicted, 0 where
  /// nothing is learned. With everything else fixed the differences depend on the model smoothly, and their
  /// weights do not reward a model for being uncertain.
  void differences(const Layer& layer, std::vector<double>& height_mm, const deposition::DropletModel& model,
                   double scatter, std::span<double> difference_mm);

 private:
  using Links = std::array<SoftLink, 8>;
  Links links_of(const deposition::DropletModel& model, double scatter) const;
  /// Neighbour n of a cell; the cell itself where that is off the grid.
  std::uint32_t neighbour(std::uint32_t cell, int n) const;
  bool on_grid(std::uint32_t cell, int n) const { return inner_[cell] || neighbour(cell, n) != cell; }
  /// What each droplet of the pass gives to its neighbours (to cells off the grid: anything), and how that
  /// changes with their heights if `sensitive`.
  void exchange(const Pass& pass, std::span<const double> height_mm, std::span<const double> variance_mm2,
                const Links& links, bool sensitive);
  /// Moves the heights past a pass whose exchange() was the last one.
  void settle(const Pass& pass, std::vector<double>& height_mm, const Links& links, double drop_mm);

  GridSpec grid_;
  deposition::Border border_;
  std::vector<std::uint8_t> inner_;          ///< all eight neighbours are on the grid,
  std::array<std::ptrdiff_t, 8> offset_{};   ///< where they are
  std::vector<double> change_, own_, from_;  // workspace,
  std::vector<double> give_mm_,
      sensitivity_;           // of neighbour n and droplet k of the pass at n * droplets_ + k
  std::size_t droplets_ = 0;  // of the pass, an even number
};

}  // namespace firn::droplet
