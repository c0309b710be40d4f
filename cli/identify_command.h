// run_identify estimates h1, h2, h3, the heights of droplets at places inside their cells, or the law of
// beads from a run, or the spacing of droplets from prints of squares.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct IdentifyOptions {
  std::vector<std::string> runs;
  /// "droplets", "places", "beads"; auto: beads where the run holds recorded speeds, places where it prints
  /// them
  std::string model = "auto";
  std::string offsets = "grid";  ///< places: kind of the table that is wanted, "x" or "grid"
  bool spacing = false;
  double diameter_mm = 0.42;  ///< d of [Lu 2015, Table I], for gamma = L / d
  std::string output;         ///< picture (SVG); empty = none
  bool json = false;
  bool unsealed = false;  ///< take runs that are not as they were sealed
};
/// @returns 0, or 1 when the run cannot identify the model (and why). @throws UsageError: not a run; runs
/// without squares with --spacing; fewer than three spacings.
int run_identify(const IdentifyOptions& options);

}  // namespace firn
