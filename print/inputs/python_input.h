// Makes the inputs of classes in Python: each one's file, the modules beside it that it imports, and the
// versions of the interpreter and of the packages.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "runtime/node.h"

namespace firn {

/// Adds the inputs of every class in Python, after each was built from them once. Nothing if there is none.
/// @param make_controller builds the print's scheme from its inputs
/// @param folder of the experiment file, to which the files are relative
/// @throws ConfigError (keys control.scheme, estimator.droplets, plant.model): the file cannot be read, an
/// import that a print does not allow, or with the traceback of an exception
void add_python_inputs(const Experiment& experiment, const std::filesystem::path& folder, const Mask& mask,
                       const std::function<void(const Blobs& inputs)>& make_controller, Blobs& inputs);

/// Returns "Python 3.11.2, numpy 1.24.2 here; the run has …" if a run was printed with other versions of the
/// interpreter or of its packages than this process has loaded; empty: with the same, or without Python.
/// Packages that this process has not loaded do not count.
std::string python_difference(const Blobs& inputs);

}  // namespace firn
