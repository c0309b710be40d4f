// SampleMesh holds a mesh made in code: such meshes reproduce tables of papers whose own mesh is not
// available.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/slice/mesh/facets.h"

namespace firn {

struct SampleMesh {
  std::vector<slice::Corner> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A closed, robed figure with folds, shoulders and a head, 172.75 mm high: 691 layers of 0.25 mm, as the
/// statue of [Barnett 2012, Fig. 3-1]. `around` x `up` rings of corners give 2 around (up - 1) facets; the
/// minimum is 3 x 3.
SampleMesh statue(std::uint32_t around, std::uint32_t up);

enum class MeshFormat { kBinaryPly, kAsciiPly, kBinaryStl, kAsciiStl };
/// Returns the bytes of a file. Text has seven significant digits and exponents, as the thesis describes it
/// [3.1.1].
std::string mesh_bytes(const SampleMesh& mesh, MeshFormat format);

}  // namespace firn
