// link_orderly() and link_any() compute the closed contours of the segments of one layer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/slice/mesh/segments.h"
#include "core/slice/mesh/slicer.h"

namespace firn::slice {

/// Working memory that is kept from layer to layer.
struct LinkWork {
  static constexpr std::size_t kPlaces = 4;
  struct Bucket {  // of segments by their first point, in the order of insertion
    std::array<std::uint32_t, kPlaces> edge, behind;  // 1 + the segment's number; 0 = free
  };
  std::vector<Segment> segments;
  std::vector<Bucket> table;
  std::vector<std::uint32_t> next;
  geometry::Rings rings;
};

/// Links the layer of a regular mesh: on every crossed edge one segment ends and one begins. One look-up per
/// segment. Returns nothing if the layer is not regular.
std::optional<geometry::Rings> link_orderly(std::span<const Segment> segments, LinkWork& work);

/// Links any layer: see docs/algorithms/slicing.md, "Linking". Sorts the segments.
Contours link_any(std::vector<Segment>& segments, const SliceOptions& options, std::int32_t layer);

}  // namespace firn::slice
