// Finds the Python files of a run among its inputs, and their roles there.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "python/host/python_host.h"

namespace firn::python {

/// Roles of inputs that hold Python files: one of these and the name of the file, level.py. One name may
/// occur under each of them.
inline constexpr std::string_view kControllerRole = "python/", kEstimatorRole = "python-estimator/",
                                  kPlantRole = "python-plant/";

/// Returns the files under `role`, the one named `first` at the beginning.
/// @param inputs with role and bytes. @throws std::invalid_argument: `first` is not among them
template <class Inputs>
std::vector<SourceFile> recorded_files(const Inputs& inputs, std::string_view role,
                                       const std::string& first) {
  std::vector<SourceFile> files;
  for (const auto& b : inputs)
    if (b.role.starts_with(role))
      files.push_back(
          {b.role.substr(role.size()), {reinterpret_cast<const char*>(b.bytes.data()), b.bytes.size()}});
  const auto main = std::ranges::find(files, first, &SourceFile::name);
  if (main == files.end()) throw std::invalid_argument(first + " is no input of this run");
  std::rotate(files.begin(), main, main + 1);
  return files;
}

}  // namespace firn::python
