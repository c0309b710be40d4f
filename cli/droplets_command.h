// run_droplets measures droplets in a user's own strobe pictures.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct DropletsOptions {
  std::vector<std::string> images;
  std::vector<double> delays_us;
  double scale_um_per_px = 0.0, nozzle_um = 0.0, pitch_um = 0.0;
  std::string target, background;
  std::string objects = "auto";
  std::string picture;  ///< PNG that is written
  bool json = false;
};

/// @returns 0. @throws UsageError
int run_droplets(const DropletsOptions& options);

/// Declares the arguments.
void declare_droplets(OptionSet& options);

}  // namespace firn
