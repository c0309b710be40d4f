// The store between intersect() and link(): per layer, in no order, the segments that facets leave in its
// plane.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/slice/mesh/facet_chunks.h"
#include "core/slice/mesh/slicer.h"

namespace firn::slice {

/// From one mesh edge to another, material on the left. Two segments meet where edge and point are equal: the
/// point is computed from the edge alone, so a chance agreement of two edges' hashes can only join what lies
/// in one place.
struct Segment {
  std::uint32_t from_edge = 0, to_edge = 0;  ///< hashes of the edges' end points
  Point from, to;
  bool operator==(const Segment&) const = default;
  auto operator<=>(const Segment&) const = default;
};

/// Per layer a chain of blocks that grow from 8 to 64 segments, cut from slabs: written once, never moved.
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
  /// Copies the layer's segments to `out` and returns its new end.
  Segment* copy(std::size_t layer, Segment* out) const;

 private:
  struct Block {
    Block* following = nullptr;
    std::uint32_t capacity = 0;
    Segment* data() { return reinterpret_cast<Segment*>(this + 1); }
    const Segment* data() const { return reinterpret_cast<const Segment*>(this + 1); }
  };
  struct Tail {  // all that each segment asks for, apart from the rest
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
  bool turned = false;             ///< the mesh was inside out: segments run the other way
};

}  // namespace firn::slice
