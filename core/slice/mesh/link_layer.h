// One layer's segments to closed contours.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/slice/mesh/segments.h"
#include "core/slice/mesh/slicer.h"

namespace firn::slice {

/// Room used again from layer to layer.
struct LinkWork {
  static constexpr std::size_t kPlaces = 4;
  struct Bucket {  // of segments by where they begin, in the order in which they came
    std::array<std::uint32_t, kPlaces> edge, behind;  // 1 + the segment's number; 0 = free
  };
  std::vector<Segment> segments;
  std::vector<Bucket> table;
  std::vector<std::uint32_t> next;
  Rings rings;
};

/// The layer of an orderly mesh: on every crossed edge one segment ends and one begins. One look-up per
/// segment. None if the layer is not so.
std::optional<Rings> link_orderly(std::span<const Segment> segments, LinkWork& work);

/// Any layer: see docs/algorithms-slicing.md, "Linking". Sorts the segments.
Contours link_any(std::vector<Segment>& segments, const SliceOptions& options, std::int32_t layer);

}  // namespace firn::slice
