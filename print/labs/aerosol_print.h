// The row of the aerosol lab in the table of print labs.
#pragma once

#include "core/grid/grid.h"
#include "core/path/print_job.h"
#include "print/labs/print_lab.h"

namespace firn {

extern const PrintLab kAerosolPrint;

/// The nominal surface of a job after all layers, and the middles of its lines (half a width to either side).
struct NominalLines {
  HeightMap target;
  Mask mask;
};
NominalLines nominal_lines(const Experiment& experiment, const PrintJob& job);

}  // namespace firn
