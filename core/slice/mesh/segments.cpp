#include "core/slice/mesh/segments.h"

#include <algorithm>
#include <new>

#include "core/geometry/pages.h"

namespace firn::slice {

Segments::Segments() = default;
Segments::~Segments() = default;
Segments::Segments(Segments&&) noexcept = default;
Segments& Segments::operator=(Segments&&) noexcept = default;

void SegmentLane::grow(std::size_t layer) {
  Chain& chain = chains_[layer];
  const std::uint32_t capacity = chain.last ? std::min<std::uint32_t>(64, 2 * chain.last->capacity) : 8;
  const std::size_t bytes = sizeof(Block) + capacity * sizeof(Segment);
  if (slab_used_ + bytes > kSlabBytes) {
    slabs_.push_back(std::make_unique_for_overwrite<std::byte[]>(kSlabBytes));
    geometry::ask_for_pages({slabs_.back().get(), kSlabBytes});
    slab_used_ = 0;
  }
  Block* block = new (slabs_.back().get() + slab_used_) Block{nullptr, capacity};
  slab_used_ += bytes;
  (chain.last ? chain.last->following : chain.first) = block;
  chain.last = block;
  chain.room += capacity;
  tails_[layer] = {block->data(), block->data() + capacity};
}

Segment* SegmentLane::copy(std::size_t layer, Segment* out) const {
  for (const Block* b = chains_[layer].first; b; b = b->following) {
    const Segment* end = b->following ? b->data() + b->capacity : tails_[layer].next;
    out = std::copy(b->data(), end, out);
  }
  return out;
}

}  // namespace firn::slice
