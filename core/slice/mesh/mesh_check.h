// MeshCheck holds the topology of a mesh edge by edge, which explains why a slice had to be repaired.
#pragma once

#include <cstddef>

#include "core/slice/mesh/mesh.h"

namespace firn::slice {

struct MeshCheck {
  std::size_t vertices = 0, facets = 0, edges = 0;
  std::size_t border_edges = 0;     ///< of one facet
  std::size_t branching_edges = 0;  ///< of more than two facets
  /// Edges of two facets that traverse them in the same direction: one of these is wound wrongly.
  std::size_t against_edges = 0;
  std::size_t duplicate_facets = 0;  ///< further facets on the same three vertices, either way round
  std::size_t flat_facets = 0;       ///< without area
  std::size_t bodies = 0;            ///< components connected by vertices
  double area_mm2 = 0.0;
  bool operator==(const MeshCheck&) const = default;
};

/// Checks a welded mesh (placement.h), in which neighbours share vertices, in n log n.
MeshCheck check(const Mesh& mesh);

}  // namespace firn::slice
