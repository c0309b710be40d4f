// Makes the inputs of a scheme in Python: its file, the modules beside it that it imports, and the versions
// of the interpreter and of the packages.
#pragma once

#include <filesystem>
#include <string>

#include "config/experiment.h"
#include "core/control/controller.h"
#include "runtime/node.h"

namespace firn {

/// Adds the inputs, after the controller was built from them once. Nothing if the scheme is in C++.
/// @param folder of the experiment file, to which the file is relative
/// @throws ConfigError (key control.scheme): the file cannot be read, an import that a print does not allow,
/// or with the traceback of an exception
void add_python_inputs(const Experiment& experiment, const control::Setup& setup,
                       const std::filesystem::path& folder, Blobs& inputs);

/// Returns "Python 3.11.2, numpy 1.24.2 here; the run has …" if a run was printed with other versions of the
/// interpreter or of its packages than this process has loaded; empty: with the same, or without Python.
std::string python_difference(const Blobs& inputs);

}  // namespace firn
