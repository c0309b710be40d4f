// Makes the inputs of driver classes in Python: each one's file, and the modules beside it that it imports.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "files/port_address.h"
#include "runtime/node.h"

namespace firn {

/// Returns name and path of the modules of an instrument's driver class, its own file first; nothing for one
/// in C++. A module is found by an import statement of its own, at any depth: `import levels`, `from levels
/// import x`; others are packages of the computer.
/// @param folder of the experiment file, to which the class's file is relative
/// @throws ConfigError (key devices.NODE.kind): a file that cannot be read
std::vector<std::pair<std::string, std::string>> driver_modules(const Experiment& experiment,
                                                                const std::string& node,
                                                                const std::filesystem::path& folder);

/// Hands each port the modules of the class that speaks through it.
std::map<std::string, PortAddress> with_driver_files(std::map<std::string, PortAddress> ports,
                                                     const Experiment& experiment,
                                                     const std::filesystem::path& folder);

/// Adds them for every instrument that takes part, under driver_role(node).
void add_driver_inputs(const Experiment& experiment, const std::filesystem::path& folder, Blobs& inputs);

}  // namespace firn
