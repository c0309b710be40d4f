// run_plan computes certified trajectories along paths (docs/commands/plan.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace firn {

struct PlanCommandOptions {
  std::string paths;              ///< path file (read_paths)
  std::string output;             ///< trajectory file; empty = none
  std::string machine;            ///< TOML
  std::vector<double> origin_mm;  ///< x, y of the part's frame in the machine's; empty = 0, 0
  std::string method = "certified";
  double fill_mm_s = 100.0;              ///< straight fill of method constant
  std::optional<double> tolerance_mm;    ///< not given: 0, or 0.05 for an aerosol machine
  std::optional<double> point_noise_mm;  ///< not given: from the decimals of each path's points
  double curvature_ramp_mm = 0.4;
  std::string corner;             ///< of an aerosol machine; empty = loop
  std::string csv, plot, pulses;  ///< further files; empty = none
  std::string gcode, pvt;         ///< programs for motion controllers
  std::string beside;             ///< method whose plan is drawn beside the other; empty = none
  std::int64_t plot_path = 1;
  int threads = 0;  ///< 0 = as many as the machine has
  bool json = false;
};

/// @returns 0; 1 when a path cannot be planned (each is named, nothing is written); 130 after Ctrl-C.
/// @throws UsageError, ConfigError
int run_plan(const PlanCommandOptions& options);

/// Returns what a path costs that takes method `optimal` more than some seconds, to be said before it is
/// planned; nothing for other methods and paths. @param place of the path in its file
std::optional<std::string> slow_path_warning(const std::string& method, const std::string& place,
                                             std::size_t points);

}  // namespace firn
