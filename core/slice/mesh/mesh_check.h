// What a mesh is as a surface, edge by edge: for whoever wants to know why a slice had to be mended.
#pragma once

#include <cstddef>

#include "core/slice/mesh/mesh.h"

namespace firn::slice {

struct MeshCheck {
  std::size_t vertices = 0, facets = 0, edges = 0;
  std::size_t border_edges = 0;     ///< of one facet
  std::size_t branching_edges = 0;  ///< of more than two facets
  std::size_t against_edges =
      0;  ///< of two facets that run through it the same way: one of them is wound wrongly
  std::size_t duplicate_facets = 0;  ///< further facets on the same three vertices, either way round
  std::size_t flat_facets = 0;       ///< without area
  std::size_t bodies = 0;            ///< parts that hang together by vertices
  double area_mm2 = 0.0;
  bool operator==(const MeshCheck&) const = default;
};

/// In n log n; a welded mesh (placement.h), so that neighbours share vertices.
MeshCheck check(const Mesh& mesh);

}  // namespace firn::slice
