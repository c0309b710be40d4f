// PythonController runs a class in a Python file as a scheme (control.scheme = "python:FILE.py:CLASS"). The
// files are inputs of the run, so that live, in one process and in replay the same bytes decide.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/control/controller.h"
#include "python/host/recorded_files.h"
#include "runtime/node.h"

namespace firn {

/// Role of an input that holds a Python file: this and the name of the file, level.py.
inline constexpr std::string_view kPythonRole = python::kControllerRole;

/// Role of the input that holds the interpreter and the packages of the run.
inline constexpr std::string_view kPythonVersionsRole = "python";

/// Returns the scheme that options.scheme names, bounded by options.max_layers.
/// @param inputs with the file and the modules that it imports
/// @throws std::invalid_argument: a bad setup, a file that is no input; std::runtime_error: the plug-in is
/// not there, or with the traceback of an exception
std::unique_ptr<control::LayerController> make_python_controller(const control::Setup& setup,
                                                                 const control::ControlOptions& options,
                                                                 const Blobs& inputs);

}  // namespace firn
