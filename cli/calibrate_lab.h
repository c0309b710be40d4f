// run_calibrate_lab runs one calibration of a lab and proposes its result for the lab file: firn calibrate
// laser-offset, laser-latency, level-table, valve-latency or flow-curve in the ice lab, jet in an ink-jet
// lab.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "studies/calibrate/lab_calibrations.h"

namespace firn {

struct CalibrateLabOptions {
  std::string what;
  std::string lab;                     ///< a lab or an experiment file; "" = the shipped one
  std::string output;                  ///< "" = LAB with .proposed.toml
  bool write = false;                  ///< into the lab file itself
  std::string valve = "a";             ///< a, b
  std::string plot;                    ///< residuals, of jet the velocities, SVG; empty = none
  std::vector<std::string> overrides;  ///< KEY=VALUE
  LabCalibrationOptions run;
  bool json = false;
};

/// "laser-offset", ...
std::vector<std::string_view> lab_calibration_names();
bool is_lab_calibration(std::string_view name);

std::string residual_svg(const LabCalibration& calibration);

/// @returns 0; 1 when the data cannot tell (and why): nothing is written then. @throws UsageError,
/// ConfigError
int run_calibrate_lab(const CalibrateLabOptions& options);

}  // namespace firn
