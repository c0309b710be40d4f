// PythonModel runs a class in a Python file as the nature of the ink-jet lab (plant.model =
// "python:FILE.py:CLASS"; contract: python/lib/firn/contract.py).
#pragma once

#include <memory>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "plant/config/world_config.h"
#include "plant/inkjet/model.h"
#include "python/host/python_host.h"

namespace firn::plant {

/// WorldConfig::own of such a world.
struct PythonNature {
  std::vector<python::SourceFile> files;  ///< that of the class first
  python::ClassName name;
};

inline bool is_python_model(std::string_view model) { return model.starts_with("python:"); }

/// Droplets of a pass reach the class together, when the jet is disarmed, the lamp exposes or the sensor
/// looks. Its memory is part of the world's saved state; the object itself is not.
/// Model's functions throw NatureError with the traceback of an exception; nothing of the pass is deposited
/// then.
/// @throws std::invalid_argument: no files; std::runtime_error: the plug-in is not there, or with the
/// traceback of an exception
std::unique_ptr<Model> make_python_model(const WorldConfig& config);

}  // namespace firn::plant
