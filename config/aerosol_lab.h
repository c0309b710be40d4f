// The row of the aerosol lab, lines of a continuous, shuttered flow on a stage [Thompson 2014], and the
// conversion of its configuration to core's structs.
#pragma once

#include <vector>

#include "config/devices.h"
#include "config/fields.h"
#include "config/labs.h"
#include "config/machine.h"
#include "core/control/lines/line_controller.h"
#include "core/motion/aerosol/plan.h"

namespace firn {

extern const LabKind kAerosolLab;

/// @pre machine.kind is "aerosol". Axes without a range in the file are not bounded.
motion::AerosolMachine aerosol_machine(const Machine& machine);

/// Returns the fields of the aerosol lab's own sections.
std::vector<Field> aerosol_fields(Experiment& experiment);

/// Without one the camera's pictures alone say what lies there.
inline bool has_profiler(const Experiment& e) { return e.devices.laser_profiler != kNoInstrument; }

control::LineSetup line_setup(const Experiment& experiment, const Machine& machine, PrintJob job);
/// The same, with ways kept to the machine's travel too: for prints to come. Recorded ones replay without.
control::LineSetup line_setup_within_travel(const Experiment& experiment, const Machine& machine,
                                            PrintJob job);

}  // namespace firn
