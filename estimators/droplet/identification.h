// Estimates h1, h2, h3 from the three experiments of [Lu 2015, V-C] in printed layers: a droplet alone, with
// its four side neighbours, with one corner neighbour, each on bare substrate. h1, h2, h3 follow from the
// height of the centre, as in the paper.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "estimators/droplet/surface_filter.h"

namespace firn::droplet {

/// A mean of repeats with a 95 % interval of Student's t.
struct Repeats {
  int n = 0;
  double mean_mm = 0.0;
  double std_error_mm = 0.0;   ///< of the mean; 0 for less than two repeats
  double half_width_mm = 0.0;  ///< of the interval
};
Repeats repeats_of(const std::vector<double>& values_mm);

/// One layer as it was printed and measured.
struct PrintedLayer {
  DropletPattern fired;
  HeightMap before, after;
  std::vector<Use> use;  ///< of the cells of `before` and `after` together
};

/// Returns every `count` layers as one: their droplets, the ground before the first, the surface after the
/// last. A cell may be used where all of them may use it; layers left over at the end are left out.
std::vector<PrintedLayer> layers_together(const std::vector<PrintedLayer>& layers, int count);

/// Rise around a centre, mean over the repeats; 5 x 5 cells, [row][column], the centre in the middle.
struct Rise {
  int n = 0;
  double mean_mm[5][5] = {};
};

struct IdentificationPrints {
  std::vector<double> single, cross,
      pair;  ///< rise of the centre [mm], one per repeat (pair: mean of its two droplets)
  std::vector<double> beside,
      at_corner;  ///< rise beside and at the corners of the singles, mean of four per repeat
  Rise single_rise, cross_rise, pair_rise;  ///< pairs turned so that the second droplet lies at +x, +y

  Repeats h1, h2, h3;    ///< [V-C]: single; (cross - single) / 4; pair - single
  Repeats side, corner;  ///< rise beside a single droplet: the same constants in model (2)
  bool complete() const { return h1.n >= 2 && h2.n >= 2 && h3.n >= 2; }
};

/// Sites are found by their droplets: nothing else fired within `bare_cells` of the site's droplets in this
/// layer or any before it. Sites with a cell that was not measured are left out.
IdentificationPrints find_identification_prints(const std::vector<PrintedLayer>& layers, int bare_cells = 3);

}  // namespace firn::droplet
