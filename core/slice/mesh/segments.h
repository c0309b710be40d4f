// Segments::Store holds, per layer and unordered, the segments in which facets intersect its plane, between
// intersect() and link().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/slice/mesh/facet_chunks.h"
#include "core/slice/mesh/slicer.h"

namespace firn::slice {

/// A segment from one mesh edge to another, with material on the left. Two segments meet where edge and point
/// are equal. The point is computed from the edge alone, so a chance collision of two edge hashes can only
/// join segments at one point.
struct Segment {
  std::uint32_t from_edge = 0, to_edge = 0;  ///< hashes of the edges' end points
  geometry::Point from, to;
  bool operator==(const Segment&) const = default;
  auto operator<=>(const Segment&) const = default;
};

/// Per layer a linked list of blocks of 8 to 64 segments, allocated from slabs: written once and never moved.
class SegmentLane {
 public:
  explicit SegmentLane(std::size_t layers) : tails_(layers), chains_(layers) {}

  Segment& add(std::size_t layer) {
    Tail& tail = tails_[layer];
    if (tail.next == tail.end) grow(layer);
    return *tail.next++;
  }
  std::size_t count(std::size_t layer) const {
    return chains_[layer].room - std::size_t(tails_[layer].end - tails_[layer].next);
  }
  /// Copies the segments of the layer to `out` and returns its new end.
  Segment* copy(std::size_t layer, Segment* out) const;

 private:
  struct Block {
    Block* following = nullptr;
    std::uint32_t capacity = 0;
    Segment* data() { return reinterpret_cast<Segment*>(this + 1); }
    const Segment* data() const { return reinterpret_cast<const Segment*>(this + 1); }
  };
  struct Tail {  // the only data that each insertion needs
    Segment* next = nullptr;
    Segment* end = nullptr;
  };
  struct Chain {
    Block* first = nullptr;
    Block* last = nullptr;
    std::size_t room = 0;  // of all blocks
  };
  void grow(std::size_t layer);

  static constexpr std::size_t kSlabBytes = 1 << 18;
  std::vector<Tail> tails_;
  std::vector<Chain> chains_;
  std::vector<std::unique_ptr<std::byte[]>> slabs_;
  std::size_t slab_used_ = kSlabBytes;
};

struct Segments::Store {
  std::size_t layers = 0;
  std::vector<SegmentLane> lanes;  ///< kWaveChunks of them
  bool turned = false;             ///< the mesh was inside out: segments are reversed
};

}  // namespace firn::slice
