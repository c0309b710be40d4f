// SensorCheck compares the first maps of a print with known facts: the height of the bare table, and the
// outline of the first deposit. A sensor or a nozzle that is not as calibrated shows here before a scheme
// answers its maps.
#pragma once

#include <string>

#include "core/grid/figure.h"
#include "core/grid/grid.h"

namespace firn {

/// Words for the text of a disturbance, and the key of its limit.
struct SensorWords {
  std::string what;       ///< "the bare table"
  std::string culprits;   ///< keys that may be wrong
  std::string calibrate;  ///< what to do
  std::string key;        ///< "laser_profiler.bias_limit_mm"
};

/// Returns a violation if the mean of the measured cells is more than `limit_mm` off 0; its figure is the
/// mean.
/// @param bare heights of the map before the first layer; NaN: not measured
/// @param limit_mm calibrated uncertainty of heights; 0 = not checked
Violation check_bare(const HeightMap& bare, double limit_mm, const SensorWords& words);

/// Returns a violation if the first deposit lies more than `limit_mm` aside of `laid`
/// (core/grid/outline_shift.h) and the shift explains a quarter of the squared residual; its figure is the
/// length of the shift.
/// @param rise of the surface [mm]; NaN: not measured
/// @param beside where other material was laid; empty: nothing
/// @param limit_mm calibrated uncertainty of places; 0 = not checked
Violation check_outline(const HeightMap& rise, const Mask& laid, const Mask& beside, double limit_mm,
                        const SensorWords& words);

/// The same where readings lie on the part alone, half a bead and more inside its edge: an offset of the
/// sensor shows as an edge that did not rise, by less than half of it. Returns a violation if one edge is
/// lower than the opposite one by 0.4 `limit_mm` and by six standard errors.
Violation check_edges(const HeightMap& rise, double limit_mm, const SensorWords& words);

}  // namespace firn
