// SurfaceFilter estimates the surface between two measurements: predicted droplet by droplet with the
// height-change model [Lu 2015, Eqs. (3)-(5)], corrected by each map, with a variance per cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
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

/// Use of a map's value of a cell.
enum class Use : std::uint8_t {
  kNothing,  ///< not measured: the prediction is kept
  kLearn,    ///< measured: corrects the surface, and the difference from the prediction enters the fit
  kAnchor,   ///< measured, but the droplets near it are uncertain: replaces the surface, not fitted
};

/// @throws std::invalid_argument "<where>: ...": another size than the grid's, a noise that is not above 0, a
/// used cell without a height
void check_map(std::string_view where, const GridSpec& grid, const HeightMap& height,
               const std::vector<Use>& use, double noise_std_mm);

/// Passes of a layer, the map after it, and the linearisation that the last reference() fixed for it.
struct Layer {
  std::vector<Pass> passes;
  std::vector<double> height_mm;
  std::vector<Use> use;
  double noise_variance_mm2 = 0.0;
  // by reference():
  std::vector<std::vector<double>> variance_mm2;  ///< of the surface before each pass
  std::vector<double> gain;                       ///< of the correction, per cell
  std::vector<double> weight;                     ///< 1 / variance of the difference, 0 where not in the fit
  std::vector<double> scatter_mm2;                ///< variance by droplets of relative scatter 1
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

  /// The bare substrate: a plane through the map plus the map's spread beyond its noise.
  /// @param use kNothing where the map does not count
  Surface substrate(std::span<const double> height_mm, std::span<const Use> use,
                    double noise_variance_mm2) const;

  /// One layer at `model`: fixes the layer's variances, gains and weights, and moves `surface` past it.
  void reference(Layer& layer, Surface& surface, const deposition::DropletModel& model, double scatter);

  /// The first half of reference(): the model's prediction of `surface` after the layer's passes, variances
  /// with the droplets' scatter.
  void predict(Layer& layer, Surface& surface, const deposition::DropletModel& model, double scatter);

  /// The same with the linearisation of reference(): moves the heights alone and writes measured - predicted,
  /// 0 where a cell does not enter the fit. With everything else fixed the differences depend on the model
  /// smoothly, and their weights do not reward a model for being uncertain.
  void differences(const Layer& layer, std::vector<double>& height_mm, const deposition::DropletModel& model,
                   double scatter, std::span<double> difference_mm);

 private:
  using Links = std::array<SoftLink, 8>;
  Links links_of(const deposition::DropletModel& model, double scatter) const;
  /// Neighbour n of a cell; the cell itself where that is off the grid.
  std::uint32_t neighbour(std::uint32_t cell, int n) const;
  bool on_grid(std::uint32_t cell, int n) const { return inner_[cell] || neighbour(cell, n) != cell; }
  /// Flows from each droplet of the pass to its neighbours (arbitrary for cells off the grid), and their
  /// derivatives by the heights if `sensitive`.
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
