// PatternPrint computes layers for system identification, independent of the measurements: random patterns
// that excite the height-change model, the identification prints [Lu 2015, V-C], squares that show the
// effect of the spacing of droplets [III-A, V-C], and rows of single droplets at each place inside their
// cells.
#pragma once

#include <vector>

#include "core/control/controller.h"
#include "core/control/prediction.h"

namespace firn::control {

/// One experiment of [Lu 2015, V-C]: a centre droplet alone, with its four side neighbours, or with one
/// corner neighbour.
struct IdentificationSite {
  enum class Kind : std::uint8_t { kSingle, kSide, kCorner };
  int i = 0, j = 0;  ///< the centre cell
  Kind kind = Kind::kSingle;
  int corner = 0;  ///< kCorner: 0..3 for (+,+), (-,+), (-,-), (+,-)
  int layer = 1;   ///< in which it is printed (each site once, on bare ground); 1-based
};
/// The most droplets of a site. Printed one by one, each layer of sites takes as many layers of the print.
inline constexpr int kSiteDroplets = 5;
/// Sites spacing_cells apart whose 3 x 3 cells lie on the mask, row by row; kinds and corners take turns, and
/// so do the layers, three sites to each.
std::vector<IdentificationSite> identification_sites(const Mask& mask, int spacing_cells, int layers);

/// An n x n matrix of droplets, `step` cells apart, its lowest cell at (i, j).
struct SquareSite {
  int i = 0, j = 0, n = 1, step = 1;
  int side_cells() const { return (n - 1) * step + 1; }
};
/// 1 x 1, 2 x 2, ... largest x largest side by side, spacing_cells of bare ground between, again and again in
/// bands over the mask.
std::vector<SquareSite> square_sites(const Mask& mask, int largest, int step, int spacing_cells);

/// One droplet alone, at a place inside its cell: every row of sites has one place, the rows take turns.
struct PlaceSite {
  int i = 0, j = 0;
  int place = 0;  ///< index of the table
  int layer = 1;  ///< in which it is printed (each site once, on bare ground)
};
/// Sites spacing_cells apart whose 5 x 5 cells lie on the mask, row by row; the layers take turns along a
/// row.
std::vector<PlaceSite> place_sites(const Mask& mask, int spacing_cells, int places, int layers);

/// Prints PatternOptions::layers layers and ends. Random patterns are keyed (seed, kPattern, layer, cell),
/// the places of their droplets likewise where there are several, so a second decision for a layer is the
/// first one again. Heights are only read to report the objective.
class PatternPrint final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument naming the option: layers below 0, fill outside (0, 1], spacing_cells or
  /// square_step below 1, largest_square outside 1..64; a mask without room for one site.
  PatternPrint(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  int layers() const { return layers_; }

 private:
  DropletPattern pattern(int layer) const;
  void add_sites(int layer, DropletPattern& drops) const;
  OffsetMap places(int layer) const;

  Setup setup_;
  PatternOptions options_;
  Predictor predict_;
  int layers_ = 0;
  std::vector<IdentificationSite> sites_;
  std::vector<SquareSite> squares_;
  std::vector<PlaceSite> places_;
};

}  // namespace firn::control
