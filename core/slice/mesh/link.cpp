#include <algorithm>
#include <bit>
#include <cstring>

#include "core/geometry/lanes.h"
#include "core/geometry/planar.h"
#include "core/slice/mesh/link_layer.h"

namespace firn::slice {
namespace {

constexpr int kLayersAtOnce = 8;  // share their working memory
constexpr std::uint32_t kDone = ~0u;

using Bucket = LinkWork::Bucket;

std::uint32_t bucket_of(std::uint32_t edge, const geometry::Point& p, int shift) {
  return ((edge ^ std::uint32_t(p.x)) * 0x9e3779b1u) >> shift;
}

// Returns a bit for each place that holds `that`.
unsigned where(const std::array<std::uint32_t, LinkWork::kPlaces>& places, std::uint32_t that) {
  static_assert(sizeof places == sizeof(geometry::Lanes4));
  geometry::Lanes4 four;
  std::memcpy(&four, places.data(), sizeof four);
  return geometry::signs(four == std::int32_t(that));
}

}  // namespace

std::optional<geometry::Rings> link_orderly(std::span<const Segment> segments, LinkWork& work) {
  const std::size_t n = segments.size();
  const int bits = std::max(4, int(std::bit_width(n / 2)));  // one to two segments a bucket
  if (bits > 30) return std::nullopt;
  const int shift = 32 - bits;
  const std::uint32_t mask = (1u << bits) - 1;
  work.table.assign(std::size_t(mask) + 1, {});
  for (std::uint32_t s = 0; s < n; ++s) {
    const Segment& mine = segments[s];
    std::uint32_t at = bucket_of(mine.from_edge, mine.from, shift);
    for (;; at = (at + 1) & mask) {
      Bucket& bucket = work.table[at];
      for (unsigned same = where(bucket.edge, mine.from_edge); same; same &= same - 1)
        if (const std::uint32_t behind = bucket.behind[std::size_t(std::countr_zero(same))];
            behind && segments[behind - 1].from == mine.from)
          return std::nullopt;
      const unsigned free = where(bucket.behind, 0);
      if (!free) continue;
      const auto place = std::size_t(std::countr_zero(free));
      bucket.edge[place] = mine.from_edge;
      bucket.behind[place] = s + 1;
      break;
    }
  }
  // Compares the edge alone, which needs only the table. The point is compared below, where the segments are
  // read in their order.
  work.next.resize(n);
  for (std::uint32_t s = 0; s < n; ++s) {
    const std::uint32_t edge = segments[s].to_edge;
    for (std::uint32_t at = bucket_of(edge, segments[s].to, shift);; at = (at + 1) & mask) {
      const Bucket& bucket = work.table[at];
      const unsigned free = where(bucket.behind, 0), same = where(bucket.edge, edge) & ~free;
      if (same) {
        work.next[s] = bucket.behind[std::size_t(std::countr_zero(same))] - 1;
        break;
      }
      if (free) return std::nullopt;  // no segment begins there
    }
  }
  geometry::Rings& rings = work.rings;
  rings.clear();
  rings.points.resize(n);
  geometry::Point* end = rings.points.data();
  for (std::uint32_t first = 0; first < n; ++first) {
    if (work.next[first] == kDone) continue;
    const geometry::Point* const begin = end;
    for (std::uint32_t s = first;;) {
      if (end == begin || end[-1] != segments[s].from)
        *end++ = segments[s].from;  // a repeated point would cost canonical() a copy
      const std::uint32_t following = work.next[s];
      if (segments[following].from != segments[s].to) return std::nullopt;  // another edge with the same hash
      work.next[s] = kDone;
      if (following == first) break;
      if (work.next[following] == kDone) return std::nullopt;  // two end where one begins
      s = following;
    }
    while (end - begin > 1 && end[-1] == *begin) --end;
    rings.ends.push_back(std::uint32_t(end - rings.points.data()));
  }
  rings.points.resize(std::size_t(end - rings.points.data()));
  return canonical(rings);
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
      if (std::optional<geometry::Rings> rings = link_orderly(work.segments, work))
        contours.rings = std::move(*rings);
      else
        contours = link_any(work.segments, options, std::int32_t(layer) + 1);
      contours.segments = count;
    }
  });
  return layers;
}

}  // namespace firn::slice
