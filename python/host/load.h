// Loads the plug-in that runs Python code (python/host/python_host.h).
#pragma once

#include "python/host/python_host.h"

namespace firn::python {

/// Returns the host of this process; loads the plug-in at the first call. Thread-safe.
/// @throws std::runtime_error naming the places that were searched, or the reason of the system
Host& host();

}  // namespace firn::python
