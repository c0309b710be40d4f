// check_3mf_package refuses 3MF files whose size or structure grows beyond bounds when they are unpacked,
// before lib3mf reads them: it follows components within components for ever.
#pragma once

#include <string>

#include "files/mesh/mesh_formats.h"

namespace firn::mesh {

inline constexpr std::size_t kMaxPlacements = 100'000;  ///< objects placed by the build and its components
inline constexpr int kMaxComponentDepth = 32;

/// Reads the ZIP archive's directory and the objects, components and items of its models (3MF core
/// specification 1.2, 4). A file that is no such archive passes, for lib3mf to refuse.
/// @throws UsageError naming the file, the part or object, and the limit
void check_3mf_package(Bytes bytes, const std::string& name);

}  // namespace firn::mesh
