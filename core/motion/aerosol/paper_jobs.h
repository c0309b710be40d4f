// Computes the print jobs of the paper's figures. Fig. 7's coordinates are not printed: these are a fit to
// the errors that the paper reports, and so are the lengths of Fig. 11. The angles are the paper's.
#pragma once

#include "core/path/print_job.h"

namespace firn::motion {

/// Fig. 7: three connected and two isolated segments at 3 mm/s, from (0, 10) to (0, 0).
PrintJob thompson_fig7();

/// Fig. 11: 14 segments of 5 mm at 3 mm/s whose inner angles fall from 125 to 5 degrees in equal steps.
PrintJob thompson_fig11();

}  // namespace firn::motion
