// run_calibrate computes the position of the second nozzle from a registration print and proposes keys for
// the lab file. Calibrations of labs are in cli/calibrate_lab.h.
#pragma once

#include <filesystem>
#include <string>

#include "cli/calibrate_lab.h"
#include "config/experiment.h"
#include "estimators/registration/nozzle_offset.h"

namespace firn {

struct CalibrateOptions {
  std::string run;     ///< run folder of a registration print, or a calibration of a lab
  std::string output;  ///< of the proposal; "" = RUN/jet_b.toml
  bool json = false;
  bool unsealed = false;    ///< take a run that is not as it was sealed
  CalibrateLabOptions lab;  ///< of the latter, but for its name, output and json
};

struct Calibration {
  registration::NozzleOffset off;  ///< measured beside believed
  double believed_x_mm = 0.0, believed_y_mm = 0.0;
  double offset_x_mm() const { return believed_x_mm + off.x.value_mm; }
  double offset_y_mm() const { return believed_y_mm + off.y.value_mm; }
};

/// From the run's first plan (the marks), its map of the bare substrate and its last map.
/// @throws UsageError: not a registration print, or one without a finished layer; data that measure_offset()
/// refuses
Calibration calibrate(const std::filesystem::path& run);

/// [jet_b] offsets with their intervals, as TOML to be taken into a lab file.
std::string proposal(const Calibration& calibration, const std::string& run_name);

int run_calibrate(const CalibrateOptions& options);

}  // namespace firn
