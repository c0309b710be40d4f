// Finds the models that the slicer's tests slice: scanned ones where they lie beside the source tree, else
// small stand-ins of the same names.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace firn::test {

/// @param name of a file of ../shared/models. @returns that file; where there is none, or FIRN_STAND_INS is
/// set, the stand-in that the build writes by scripts/make_mesh.py --stand-ins
inline std::filesystem::path model_file(const std::string& name) {
  if (!std::getenv("FIRN_STAND_INS"))
    for (const char* folder : {"/../shared/models/", "/../../shared/models/"}) {
      const std::filesystem::path scanned = std::string(FIRN_SOURCE_DIR) + folder + name;
      if (std::filesystem::exists(scanned)) return scanned;
    }
  return std::filesystem::path(FIRN_BINARY_DIR) / "models" / name;
}

}  // namespace firn::test
