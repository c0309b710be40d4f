// Mesh holds indexed triangles on the integer grid of the slicer.
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

/// Seen from outside, the corners of a triangle run counter-clockwise. The surface may be open, self-
/// intersecting or inconsistently oriented: slicing defines the meaning of a broken mesh.
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace firn::slice
