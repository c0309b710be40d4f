// Holds the row of the ink-jet lab in the table of print labs.
#pragma once

#include "print/labs/print_lab.h"

namespace firn {

extern const PrintLab kInkjetPrint;

}  // namespace firn
