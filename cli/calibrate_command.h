// firn calibrate RUN: where the second nozzle stands, from a registration print; proposes the lab file's
// keys. With the name of a calibration of the ice lab instead of a run: cli/calibrate_lab.h.
#pragma once

#include <filesystem>
#include <string>

#include "cli/calibrate_lab.h"
#include "config/experiment.h"
#include "estimators/registration/nozzle_offset.h"

namespace firn {

struct CalibrateOptions {
  std::string run;     ///< run folder of a registration print, or a calibration of the ice lab
  std::string output;  ///< of the proposal; "" = RUN/jet_b.toml
  bool json = false;
  CalibrateLabOptions lab;  ///< of the latter, but for what, output and json
};

struct Calibration {
  registration::NozzleOffset off;  ///< measured beside believed
  double believed_x_mm = 0.0, believed_y_mm = 0.0;
  double offset_x_mm() const { return believed_x_mm + off.x.value_mm; }
  double offset_y_mm() const { return believed_y_mm + off.y.value_mm; }
};

/// From the run's first plan (the marks), its map of the bare substrate and its last map.
/// @throws UsageError: not a registration print, or one without a finished layer; what measure_offset()
/// refuses
Calibration calibrate(const std::filesystem::path& run);

/// [jet_b] offsets with their intervals, as TOML to be taken into a lab file.
std::string proposal(const Calibration& calibration, const std::string& run_name);

int run_calibrate(const CalibrateOptions& options);

}  // namespace firn
