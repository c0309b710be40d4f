// identify computes the parameters of the height-change model: h1, h2, h3 with 95 % intervals [Lu 2015, V-C];
// spacing_of computes the spacing of droplets from prints of squares [Lu 2015, IV].
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/statistics/held_out.h"
#include "estimators/droplet/spacing.h"
#include "print/folder/observed_run.h"

namespace firn {

/// Holds a value with its interval of 95 %, mm.
struct Known {
  double mean_mm = 0.0, half_width_mm = 0.0;
};

struct Identification {
  int layers = 0;
  std::int64_t droplets = 0;
  double noise_std_mm = 0.0;
  droplet::IdentificationPrints prints;  ///< [Lu 2015, V-C]; not complete() in a run without them
  /// The fit of (3)-(5) to all layers, by droplet_estimator.
  droplet::Estimate fit;
  Known h1, h2, h3, layer_height;
  bool prior_of_maps =
      false;  ///< the prior has the size of the maps' rise per droplet, not that of the model
  /// For h1, h2, h3: empty, or the reason for which the value is not found: "at its bound", "at its prior".
  std::array<std::string, 3> not_found;
  statistics::HeldOut held_out;  ///< of the last third of the layers
  /// Empty, or the reason for which the layers do not distinguish h1, h2 and h3. The excitation is looked at
  /// first.
  std::string uninformative;
};
Identification identify(const ObservedRun& run);

/// Returns the three prints' mean surfaces and h1..h3 by either way, about the paper's values. One <svg>.
std::string identification_svg(const Identification& id);

/// Returns the spacing from one run of squares (control.pattern.kind = "squares").
droplet::SpacingResult spacing_of(const ObservedRun& run, double droplet_diameter_mm);
std::string spacing_svg(const std::vector<droplet::SpacingResult>& results,
                        const droplet::SpacingChoice& choice);

}  // namespace firn
