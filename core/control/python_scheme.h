// PythonScheme holds the parts of control.scheme = "python:FILE.py:CLASS", a scheme that is a class in a
// Python file (python/README.md).
#pragma once

#include <string>
#include <string_view>

namespace firn::control {

struct PythonScheme {
  std::string file;        ///< relative to the folder of the experiment file
  std::string class_name;  ///< of the file
  std::string arguments;   ///< "gain=0.5, rows=3" of "CLASS(gain=0.5, rows=3)"; empty: no arguments

  std::string file_name() const;  ///< without its folder
};

/// Largest number of droplets per cell and layer of such a scheme.
inline constexpr int kMaxPythonDrops = 15;

inline constexpr std::string_view kPythonSchemeForm = "python:FILE.py:CLASS";

inline bool is_python_scheme(std::string_view scheme) { return scheme.starts_with("python:"); }

/// @throws std::invalid_argument naming the part of the text that is wrong
PythonScheme parse_python_scheme(std::string_view scheme);

std::string to_text(const PythonScheme& scheme);

}  // namespace firn::control
