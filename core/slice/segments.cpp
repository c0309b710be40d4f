#include "core/slice/segments.h"

#include <algorithm>
#include <new>

namespace firn::slice {

Segments::Segments() = default;
Segments::~Segments() = default;
Segments::Segments(Segments&&) noexcept = default;
Segments& Segments::operator=(Segments&&) noexcept = default;

void SegmentLane::grow(std::size_t layer) {
  Chain& chain = chains_[layer];
  const std::uint32_t capacity = chain.last ? std::min<std::uint32_t>(64, 2 * chain.last->capacity) : 8;
  const std::size_t bytes = sizeof(Block) + capacity * sizeof(Record);
  if (slab_used_ + bytes > kSlabBytes) {
    slabs_.push_back(std::make_unique_for_overwrite<std::byte[]>(kSlabBytes));
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
  bool near = true;
  for (const Block* b = chains_[layer].first; b; b = b->following) {
    const Record* const end = b->following ? b->data() + b->capacity : tails_[layer].next;
    for (const Record* r = b->data(); r != end; ++r) {
      if (!near) [[unlikely]] {
        out[-1].to = r->from, near = true;
        continue;
      }
      near = r->x != std::int16_t(kNotNear);
      *out++ = {r->from_edge, r->to_edge, r->from, {r->from.x + r->x, r->from.y + r->y}};
    }
  }
  return out;
}

}  // namespace firn::slice
