// run_slice computes deposition paths from meshes (docs/commands/slice.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace firn {

struct SliceCommandOptions {
  std::vector<std::string>
      meshes;  ///< *.stl, *.ply, *.obj, *.3mf; behind "--support overhang" also the angle
  std::string
      experiment;      ///< instead of meshes and settings: the part of an experiment, as its print slices it
  std::string output;  ///< path file; empty = none
  std::string config;  ///< TOML; empty = the defaults
  std::vector<std::string> overrides;  ///< KEY=VALUE
  std::string support;                 ///< full, overhang, none; empty = as the settings say
  std::optional<double> tolerance_mm;  ///< not given: as the settings say
  std::string gcode;
  std::vector<int> layers;  ///< to be pictured
  std::string svg, png, layer_json;
  int png_width = 1200;
  int threads = 0;  ///< 0 = as many as the machine has
  bool json = false;
};

/// @returns 0; 130 after Ctrl-C, and nothing was written then. @throws UsageError, ConfigError
int run_slice(const SliceCommandOptions& options);

}  // namespace firn
