// firn identify RUN: h1, h2, h3 of the height-change model with 95 % intervals, from what a run's devices
// reported and its profiler measured. firn identify --spacing RUN...: the spacing of droplets from prints of
// squares.
#pragma once

#include <string>
#include <vector>

#include "print/folder/observed_run.h"
#include "estimators/droplet/spacing.h"

namespace firn {

/// A value with its interval of 95 %, mm.
struct Known {
  double mean_mm = 0.0, half_width_mm = 0.0;
};

struct Identification {
  int layers = 0;
  std::int64_t droplets = 0;
  double noise_std_mm = 0.0;
  droplet::IdentificationPrints prints;  ///< [Lu 2015, V-C]; not complete() where the run holds none
  /// (3)-(5) to all layers, by droplet_estimator
  droplet::Estimate fit;
  Known h1, h2, h3, layer_height;
  /// Empty, or why the layers do not tell h1, h2 and h3 apart.
  std::string uninformative;
};
Identification identify(const ObservedRun& run);

/// The three prints' mean surfaces and h1..h3 by either way, about the paper's values. One <svg>.
std::string identification_svg(const Identification& id);

/// One run of squares (control.pattern.kind = "squares").
droplet::SpacingResult spacing_of(const ObservedRun& run, double droplet_diameter_mm);
std::string spacing_svg(const std::vector<droplet::SpacingResult>& results,
                        const droplet::SpacingChoice& choice);

struct IdentifyOptions {
  std::vector<std::string> runs;
  bool spacing = false;
  double diameter_mm = 0.42;  ///< d of [Lu 2015, Table I], for gamma = L / d
  std::string output;         ///< picture (SVG); empty = none
  bool json = false;
};
/// @returns 0, or 1 when the run cannot identify the model (and why). @throws UsageError: not a run; runs
/// without squares with --spacing; fewer than three spacings.
int run_identify(const IdentifyOptions& options);

}  // namespace firn
