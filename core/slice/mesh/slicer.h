// slice() computes the regions of all layers of a part: FACETSLICE [Barnett, 3.2], facets -> segments ->
// linked contours -> a Region per layer.
//
// Layers are 1-based: layer n fills (n - 1) h <= z <= n h and is cut once, at its middle (n - 0.5) h, rounded
// down to a half unit of the grid (0.05 um), so that no vertex lies on a plane. A layer exists while its
// plane is below the top.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/region.h"
#include "core/grid/parallel.h"
#include "core/options/option.h"
#include "core/slice/mesh/defects.h"
#include "core/slice/mesh/facets.h"
#include "core/slice/mesh/placement.h"

namespace firn::slice {

struct SliceOptions {
  double layer_height_mm = 0.25;
  double chord_tolerance_mm =
      0.05;  ///< contours are simplified within this distance, both ways; 0 keeps all points
  double min_spacing_mm =
      0.0;  ///< PATHFILTER: points closer than this to the last one kept are removed; 0 keeps all
  double closing_gap_mm = 2.0;  ///< ends of open contours at most this far apart are joined
  double closing_share =
      0.5;  ///< then contours whose own ends lie within this share of their length are closed
};
inline constexpr Option kLayerHeight{"layer_height_mm", &SliceOptions::layer_height_mm, "mm",
                                     within(0.001, 100), "layer n is cut once, at (n - 1/2) of this"};
inline constexpr Option kChordTolerance{"chord_tolerance_mm", &SliceOptions::chord_tolerance_mm, "mm",
                                        within(0, 10),
                                        "no path leaves its exact place by more; 0 keeps every point"};
inline constexpr OptionTable kContourOptions{
    Option{"min_spacing_mm", &SliceOptions::min_spacing_mm, "mm", within(0, 100),
           "PATHFILTER: points closer together go first (3.2: 0.4)"},
    Option{"closing_gap_mm", &SliceOptions::closing_gap_mm, "mm", within(0, 1000),
           "ends of open contours at most so far apart are joined"},
    Option{"closing_share", &SliceOptions::closing_share, "", within(0, 1),
           "then a contour whose own ends lie within this share of its length is closed"},
};
/// @throws std::invalid_argument naming the option that is out of its range
void check(const SliceOptions& options);

/// Properties of the facets as a whole; exact, and independent of their order.
struct MeshFacts {
  std::size_t facets = 0;
  std::size_t not_finite = 0;
  std::size_t degenerate = 0;
  bool closed =
      false;  ///< every edge is traversed equally often in both directions (no border, consistent winding)
  double volume_mm3 = 0.0;  ///< by the divergence theorem; for an open surface it depends on the origin
  double coarse_mm = 0.0;   ///< as Affine has it
  Vertex low, high;
};

/// Neighbouring floats farther apart than this are a defect: it is the height of the finest layer.
inline constexpr double kCoarse_mm = 1e-3;

struct SliceCounts {
  std::size_t segments = 0;         ///< facet-plane intersections
  std::size_t contours = 0;         ///< after linking
  std::size_t linked_points = 0;    ///< before PATHFILTER [Table 3-3]
  std::size_t kept_points = 0;      ///< after it
  std::size_t repaired_layers = 0;  ///< whose contours crossed or touched
};

/// Returns the heights of the planes of all layers below `top` (units), each half a unit above the value
/// given.
/// @throws std::invalid_argument: height not above 1 um or not finite, more than a million layers.
std::vector<std::int32_t> layer_planes(double layer_height_mm, std::int32_t top);

/// The intersections of facets and planes, which link() consumes.
class Segments {
 public:
  Segments();
  ~Segments();
  Segments(Segments&&) noexcept;
  Segments& operator=(Segments&&) noexcept;
  struct Store;
  std::unique_ptr<Store> store;
  MeshFacts facts;
};

/// INTERSECTFACET: one pass over the facets. @param planes ascending, from layer_planes or other heights.
Segments intersect(const FacetView& facets, const Affine& affine, std::span<const std::int32_t> planes,
                   const ParallelFor& parallel);

/// Closed contours of a layer, directed so that material lies left, each from its smallest point, sorted.
struct Contours {
  geometry::Rings rings;
  std::vector<Defect> defects;
  std::size_t segments = 0;
};

/// SEGMERGE: links segments by the mesh edges on which they end, in linear time.
std::vector<Contours> link(Segments&& segments, const SliceOptions& options, const ParallelFor& parallel);

struct Sliced {
  std::vector<geometry::Region> layers;  ///< [n - 1] = layer n
  /// [n - 1]: the contours from which layers[n - 1] was simplified; empty where anything else changed them
  /// too.
  std::vector<geometry::Rings> contours;
  std::vector<Defect> defects;  ///< whole mesh first, then by layer
  MeshFacts facts;
  SliceCounts counts;
};

/// PATHFILTER, then the area where the winding number of the contours is positive. Layers one on the other
/// that have the same section (same_section.h) have the same region, that of the lowest of them.
Sliced regions(std::vector<Contours>&& contours, const MeshFacts& facts, const SliceOptions& options,
               const ParallelFor& parallel);

/// All stages. @throws std::invalid_argument as place() and layer_planes(), or an option below 0 or not
/// finite.
Sliced slice(const FacetView& facets, const Placement& placement, const SliceOptions& options,
             const ParallelFor& parallel);

/// Makes several parts of one job disjoint: each layer of a later part loses the area of the earlier ones.
/// The parts may differ in the number of layers.
void subtract_by_priority(std::span<std::vector<geometry::Region>*> parts_by_priority,
                          const ParallelFor& parallel);

}  // namespace firn::slice
