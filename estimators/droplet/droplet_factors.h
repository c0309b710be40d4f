// DropletFactors estimates the height of real droplets as a share of the height-change model's: one factor
// for those inside the part, one for those on its rim, and one for those between. A jet's flow drifts, and at
// the foot of a wall ink runs off the part. Both effects are far from the identified h1..h3, and separate
// estimates of h1, h2, h3 could not represent them. For given heights the model's rise is linear in the
// droplets and in h1..h3 together [Lu 2015, Eq. (4)], so a layer gives
//   Z - H = sum over k of f_k P_k + noise,   P_k: rise by the model of the droplets of place k, cell by cell,
// and f_k follows from the sum over the cells of its own place, with the others' estimated shares: volumes
// are compared, however wide nature spreads them (cell by cell a droplet that spreads further than the
// model's would pass for a small one). Each factor is a random walk, followed by a Kalman filter, whose gain
// falls with the number of droplets: a layer of few droplets carries little information and does not replace
// that of full layers. Only + - * /.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/grid.h"
#include "estimators/droplet/surface_filter.h"

namespace firn::droplet {

/// Where on the part a droplet lands.
enum class Place : std::uint8_t { kInside, kRim, kBetween };

struct DropletFactorOptions {
  deposition::DropletModel model;
  deposition::Border border = deposition::Border::kLose;
  std::array<double, 3> walk_std = {0.02, 0.1,
                                    0.02};  ///< by Place: how far a factor goes from layer to layer
  double prior_std = 0.3;                   ///< of a factor about 1 at first, and at most, above 0
  double cell_std_mm = 5e-3;  ///< weighs layers: std of one cell's rise about the model's, above 0
  /// Above 0: not cells but fill weighs the layers of places other than the rim. Where all cells fire,
  /// found_k is off by kFullStd; where a part 1 - p of them does not, by this times (1 - p)^2 more.
  double sparse_std = 0.0;
};

/// kRim: beside a cell that is not of the part, or at the grid's edge; kBetween: the next two rows of cells,
/// if the part is wide enough to have an inside; kInside: the rest, and all that is not of the part.
Grid<Place> places_of(const Mask& mask);

class DropletFactors {
 public:
  static constexpr double kMin = 0.3, kMax = 3.0;  ///< factors stay within
  static constexpr double kFullStd = 0.005;        ///< of a full layer's factor, see sparse_std
  /// Lower bound of the rim's factor as a share of the inside's. Late in a print, when only the rim is short,
  /// its droplets add a tenth here and half there; planned with their mean, too many are fired, every cell of
  /// the rim ends too high, and the ink that runs off raises the cells behind it.
  static constexpr double kMinRim = 0.85;

  /// @throws std::invalid_argument: a bad model or option, a mask of another size.
  DropletFactors(const GridSpec& grid, const Mask& mask, const DropletFactorOptions& options);

  /// One layer: the surface before it, its passes, the map after it. Cells not marked kLearn, and those that
  /// differ from the expected rise by more than 5 um and half of it (droplets that did not come), are left
  /// out.
  /// @pre sizes equal to the grid's; heights before finite
  void add_layer(std::span<const double> before_mm, std::span<const Pass> passes,
                 std::span<const double> after_mm, std::span<const Use> use);

  double at(Place place) const { return factor_[std::size_t(place)]; }
  const Grid<Place>& places() const { return place_; }

 private:
  static constexpr std::size_t kPlaces = 3;
  GridSpec grid_;
  DropletFactorOptions options_;
  Grid<Place> place_;
  deposition::HeightChange<1> model_;
  std::array<double, kPlaces> factor_{1.0, 1.0, 1.0};
  std::array<double, kPlaces> variance_{}, cells_{};
  std::array<Grid<double>, kPlaces> rise_;
  HeightMap height_, changed_;
  DropletPattern drops_;
};

}  // namespace firn::droplet
