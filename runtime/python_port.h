// Names of the ports and inputs of driver classes in Python.
#pragma once

#include <string>
#include <string_view>

namespace firn {

/// Port of the program in which the driver class of a node runs.
inline std::string python_port(std::string_view node) { return std::string(node) + ".python"; }

/// Role of the inputs that hold its modules; the name of the file follows.
inline std::string driver_role(std::string_view node) { return "python-driver/" + std::string(node) + "/"; }

}  // namespace firn
