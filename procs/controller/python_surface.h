// PythonSurface runs a class in a Python file as the scheme of a print along paths (control.scheme =
// "python:FILE.py:CLASS" in an ice lab; contract: python/lib/firn/contract.py).
#pragma once

#include <cstdint>
#include <memory>

#include "core/control/surface/surface_controller.h"
#include "runtime/node.h"

namespace firn {

/// Returns the scheme that options.scheme names: its action is checked, resampled, bounded and counted as
/// that of any scheme. @param seed of its random numbers
/// @throws std::invalid_argument naming the option, or a file that is no input; std::runtime_error: the
/// plug-in is not there, or with the traceback of an exception
std::unique_ptr<control::SurfaceController> make_python_surface(const control::SurfaceOptions& options,
                                                                std::uint64_t seed, const Blobs& inputs);

}  // namespace firn
