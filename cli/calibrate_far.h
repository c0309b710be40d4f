// A calibration whose instruments are at another computer is carried out there, beside its instruments.
#pragma once

#include <string>

#include "cli/calibrate_lab.h"
#include "config/experiment.h"

namespace firn {

/// Returns the host at which the calibration's instruments are; empty: this computer.
/// @throws UsageError naming instruments of two computers: their signals meet in one lab
std::string host_of_calibration(const Experiment& lab);

/// Carries the calibration out at the host. Questions to a person are asked here.
/// @param machine text of the ice lab's machine; empty: it has none
/// @throws calibration::Unidentifiable as the calibration itself; std::runtime_error: the host or an act
/// failed, and has said why
LabCalibration calibrate_at_host(const Experiment& lab, const std::string& host,
                                 const CalibrateLabOptions& options, const std::string& machine);

/// Returns the answer of firn calibrate --json, and with --plot - the drawing as "svg".
/// @throws std::runtime_error: the text is no such answer
LabCalibration lab_calibration_in(const std::string& json);

}  // namespace firn
