#include <algorithm>
#include <bit>

#include "core/slice/link_layer.h"
#include "core/slice/rings.h"

namespace firn::slice {
namespace {

constexpr int kLayersAtOnce = 4;  // share their room
constexpr std::uint32_t kDone = ~0u;

std::uint32_t slot_of(std::uint32_t edge, const Point& p, int shift) {
  return ((edge ^ std::uint32_t(p.x)) * 0x9e3779b1u) >> shift;
}

}  // namespace

std::optional<Rings> link_orderly(std::span<const Segment> segments, LinkWork& work) {
  const std::size_t n = segments.size();
  const int bits = std::max(4, int(std::bit_width(2 * n)));
  if (bits > 31) return std::nullopt;
  const int shift = 32 - bits;
  const std::uint32_t mask = (1u << bits) - 1;
  work.table.assign(std::size_t(mask) + 1, 0);  // segment + 1, by where it begins
  for (std::uint32_t s = 0; s < n; ++s) {
    std::uint32_t slot = slot_of(segments[s].from_edge, segments[s].from, shift);
    for (; work.table[slot]; slot = (slot + 1) & mask) {
      const Segment& other = segments[work.table[slot] - 1];
      if (other.from_edge == segments[s].from_edge && other.from == segments[s].from) return std::nullopt;
    }
    work.table[slot] = s + 1;
  }
  work.next.resize(n);
  for (std::uint32_t s = 0; s < n; ++s) {
    std::uint32_t slot = slot_of(segments[s].to_edge, segments[s].to, shift);
    for (;; slot = (slot + 1) & mask) {
      if (work.table[slot] == 0) return std::nullopt;  // taken already, or none begins there
      if (work.table[slot] == kDone) continue;
      const Segment& other = segments[work.table[slot] - 1];
      if (other.from_edge == segments[s].to_edge && other.from == segments[s].to) break;
    }
    work.next[s] = work.table[slot] - 1;
    work.table[slot] = kDone;
  }
  Rings rings;
  rings.points.reserve(n);
  for (std::uint32_t first = 0; first < n; ++first) {
    if (work.next[first] == kDone) continue;
    work.ring.clear();
    for (std::uint32_t s = first; work.next[s] != kDone;) {
      work.ring.push_back(segments[s].from);
      const std::uint32_t following = work.next[s];
      work.next[s] = kDone;
      s = following;
    }
    append_canonical(work.ring, rings);
  }
  return sorted(rings);
}

std::vector<Contours> link(Segments&& segments, const SliceOptions& options, const ParallelFor& parallel) {
  const std::unique_ptr<Segments::Store> store = std::move(segments.store);
  std::vector<Contours> layers(store->layers);
  const int groups = int((store->layers + kLayersAtOnce - 1) / kLayersAtOnce);
  parallel(groups, [&](int group) {
    LinkWork work;
    const std::size_t first = std::size_t(group) * kLayersAtOnce;
    for (std::size_t layer = first; layer < std::min(first + kLayersAtOnce, store->layers); ++layer) {
      std::size_t count = 0;
      for (const SegmentLane& lane : store->lanes) count += lane.count(layer);
      work.segments.resize(count);
      Segment* out = work.segments.data();
      for (const SegmentLane& lane : store->lanes) out = lane.copy(layer, out);
      if (store->turned)
        for (Segment& s : work.segments) s = {s.to_edge, s.from_edge, s.to, s.from};
      Contours& contours = layers[layer];
      if (std::optional<Rings> rings = link_orderly(work.segments, work))
        contours.rings = std::move(*rings);
      else
        contours = link_any(work.segments, options, std::int32_t(layer) + 1);
      contours.segments = count;
    }
  });
  return layers;
}

}  // namespace firn::slice
