// PlanCost holds the weights of a plan's cost: Eq. (8) [Lu 2015], or the root of the mean square of the
// errors.
#pragma once

#include "core/control/options.h"

namespace firn::control::mpc {

/// alpha E + (1 - alpha) std(e) over the part after the last layer. E is avg|e| (kAbsolute, the paper's) or
/// the root of avg(e^2 + droplets price_mm2 / cells) (kSquare). Droplets vary in size independently of each
/// other, so that the expected e^2 is linear in the droplets: price_mm2 is the sum over cells of the variance
/// that one of them adds. To it comes mean_weight times the square of the mean error, which a part's volume
/// and thickness show and single cells do not. Height that the plan adds beside the part, o mm in all, costs
/// outside_price o / cells (kAbsolute), or outside_price times a layer's height times o / cells under the
/// root (kSquare).
struct PlanCost {
  double alpha = 1.0;
  ErrorKind error = ErrorKind::kAbsolute;
  double price_mm2 = 0.0;
  double mean_weight = 0.0;  ///< kSquare
  double outside_price = 0.0;
};

}  // namespace firn::control::mpc
