// Triangles on the slicer's integer grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/region.h"

namespace firn::slice {

struct Vertex {
  std::int32_t x = 0, y = 0, z = 0;  ///< units of kMmPerUnit
  bool operator==(const Vertex&) const = default;
};

/// Indexed triangles; seen from outside their corners run counter-clockwise. Whether the surface is closed,
/// simple or oriented is not promised: slicing defines what a broken mesh means.
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace firn::slice
