// result_fingerprint() computes what the functions of C, OpenCV, NLopt and SUNDIALS give on this computer.
// Apart from the value, since few programs are linked with all of these.
#pragma once

#include "runtime/fingerprint.h"

namespace firn {

/// Returns the fingerprint of this process, computed once in some milliseconds: of every library function
/// whose values may depend on the CPU and which a node, a world or a study calls (scripts/check_symbols.py
/// finds a missing one).
const Fingerprint& result_fingerprint();

}  // namespace firn
