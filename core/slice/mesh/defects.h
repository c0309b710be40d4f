// Defect holds one finding about a mesh: its kind, layer and location. Findings are repaired by the rules of
// docs/algorithms/slicing.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/geometry/region.h"

namespace firn::slice {

enum class DefectKind : std::uint8_t {
  kNotFinite,    ///< facets with a corner that is not a number; left out
  kDegenerate,   ///< facets without area on the grid; they bound nothing
  kNotClosed,    ///< the surface has a border or facets wound against each other (whole mesh)
  kBelow,        ///< part of the mesh lies below z = 0; not printed
  kInsideOut,    ///< the volume is negative: all facets were turned (whole mesh)
  kBranching,    ///< more than two facets met on an edge; size = number of such crossings
  kTurned,       ///< contours with facets wound against the rest, or inside out; turned
  kGapClosed,    ///< contour closed over a gap of size_mm
  kOpenDropped,  ///< open contour of length size_mm left out
  kCoarse,       ///< coordinates are so large that the file's floats are size_mm apart (whole mesh)
  kOverlap,      ///< contours crossed or touched; replaced by the area whose winding number is positive
};

/// One finding. Findings of one kind in a layer without a size of their own are counted together.
struct Defect {
  DefectKind kind = DefectKind::kNotFinite;
  std::int32_t layer = 0;  ///< 1-based; 0 = the mesh as a whole
  geometry::Point at;      ///< first point in the order of points; 0, 0 for the mesh as a whole
  double size_mm = 0.0;    ///< gap or length where the kind has one
  std::size_t count = 1;
  bool operator==(const Defect&) const = default;
};

std::string_view name(DefectKind kind);         ///< "gap_closed": for JSON
std::string_view explanation(DefectKind kind);  ///< "a gap in a contour was closed": for people

}  // namespace firn::slice
