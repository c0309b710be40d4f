// INTERSECTFACET [Barnett, 3.2], some hundred facets at a time: each facet is read once, measured, and leaves
// a segment in every plane that it crosses. Cases that depend on the order of its corners come from tables,
// without unpredictable branches.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "core/options/range.h"
#include "core/slice/mesh/plane_finder.h"
#include "core/slice/mesh/segments.h"
#include "core/slice/mesh/snap_facets.h"

namespace firn::slice {
namespace {

std::uint64_t hash(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = std::uint64_t(x) * 0x9e3779b97f4a7c15ull + std::uint64_t(y) * 0xc2b2ae3d27d4eb4full +
                    std::uint64_t(z) * 0x165667b19e3779f9ull;
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93ull;
  return h ^ (h >> 29);
}

struct Sums {
  std::size_t not_finite = 0, degenerate = 0;
  std::uint64_t border =
      0;  // 0 exactly when the edges cancel (docs/algorithms/slicing.md), but for chance 2^-60
  __int128 six_volumes = 0;
  void add(const Sums& s) {
    not_finite += s.not_finite;
    degenerate += s.degenerate;
    border += s.border;
    six_volumes += s.six_volumes;
  }
};

using Grid = const std::int32_t*;  // a corner's x, y, z

bool no_area(Grid a, Grid b, Grid c) {
  const std::int64_t bx = std::int64_t(b[0]) - a[0], by = std::int64_t(b[1]) - a[1],
                     bz = std::int64_t(b[2]) - a[2];
  const std::int64_t cx = std::int64_t(c[0]) - a[0], cy = std::int64_t(c[1]) - a[1],
                     cz = std::int64_t(c[2]) - a[2];
  return bx * cy == by * cx && by * cz == bz * cy && bx * cz == bz * cx;
}

bool equal(Grid a, Grid b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

/// The corners that bound the edges on which the segments of a facet begin and end, by the order of the
/// heights of its corners. Seen from outside with z up, the middle corner of a facet whose corners run low,
/// middle, high lies on the right; material to the left of a segment means that it runs to the right.
struct Way {
  std::uint8_t from_low, from_high, to_low, to_high, middle, high;
};

/// [b lower than a, c lower than a << 1, c lower than b << 2][the plane is above the middle corner]
constexpr std::array<std::array<Way, 2>, 8> ways() {
  std::array<std::array<Way, 2>, 8> all{};
  for (unsigned order = 0; order < 8; ++order) {
    const bool b_a = order & 1, c_a = order & 2, c_b = order & 4;
    unsigned low = b_a ? 1 : 0, high = b_a ? 0 : 1;
    if (low == 1 ? c_b : c_a) low = 2;
    if (high == 1 ? !c_b : !c_a) high = 2;
    const unsigned middle = low == high ? low : 3 - low - high;  // for an impossible order
    const bool rightward = (low + 1) % 3 != high;
    for (unsigned upper = 0; upper < 2; ++upper) {
      const auto p = std::uint8_t(upper ? middle : low), q = std::uint8_t(upper ? high : middle);
      const auto l = std::uint8_t(low), m = std::uint8_t(middle), h = std::uint8_t(high);
      all[order][upper] = rightward ? Way{l, h, p, q, m, h} : Way{p, q, l, h, m, h};
    }
  }
  return all;
}
constexpr auto kWays = ways();

using Pair = double __attribute__((vector_size(16)));

/// Returns the crossing of an edge and a plane, computed from its lower end: identical for both facets of the
/// edge.
geometry::Point crossing(Grid low, Grid high, double plane) {
  const Pair p = {double(low[0]), double(low[1])}, q = {double(high[0]), double(high[1])};
  const double z = low[2];
  const double inverse = 1.0 / (double(high[2]) - z);
  const Pair at = (p + ((q - p) * inverse) * (plane - z)) + kRounding;
  using Words = std::int32_t __attribute__((vector_size(16)));
  const Words words = std::bit_cast<Words>(at);
  return {words[0], words[2]};
}

class Cutter {
 public:
  Cutter(const PlaneFinder& planes, SegmentLane& lane, Sums& sums)
      : planes_(planes), lane_(lane), sums_(sums) {}

  static constexpr std::size_t kFacets =
      128;  // with their intermediate results they fit the first-level cache
  std::int32_t* grid() { return grid_; }

  void cut(std::size_t facets) {
    const std::size_t hits = measure(facets);
    for (std::size_t n = 0; n < hits; ++n) across(hits_[n]);
  }

 private:
  struct Hit {
    std::uint32_t plane;
    std::uint16_t facet, order;
  };

  // Sums volume, border and area of all facets and lists those that cross a plane.
  std::size_t measure(std::size_t facets) {
    std::size_t hits = 0;
    std::uint64_t border = 0;
    __int128 six_volumes = 0;
    for (std::size_t n = 0; n < facets; ++n) {
      const Grid a = grid_ + 9 * n, b = a + 3, c = a + 6;
      const std::int64_t ax = a[0], ay = a[1], az = a[2], bx = b[0], by = b[1], bz = b[2], cx = c[0],
                         cy = c[1], cz = c[2];
      const std::uint64_t ha = hash(ax, ay, az), hb = hash(bx, by, bz), hc = hash(cx, cy, cz);
      hashes_[3 * n] = std::uint32_t(ha >> 32);
      hashes_[3 * n + 1] = std::uint32_t(hb >> 32);
      hashes_[3 * n + 2] = std::uint32_t(hc >> 32);
      // Each directed edge (a, b) adds a^2 b - a b^2, which its opposite cancels.
      border += (ha - hb) * (hb - hc) * (hc - ha);
      const std::int64_t twice_shadow = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
      six_volumes += __int128(twice_shadow) * (az + bz + cz);
      if (twice_shadow == 0 && no_area(a, b, c)) {
        ++sums_.degenerate;
        if (equal(a, b) || equal(b, c) || equal(c, a))
          continue;  // its two crossed edges coincide: no segment
      }
      const std::uint32_t k = planes_.at_or_above(std::min({a[2], b[2], c[2]}));
      hits_[hits] = {k, std::uint16_t(n),
                     std::uint16_t(unsigned(bz < az) | unsigned(cz < az) << 1 | unsigned(cz < bz) << 2)};
      hits += planes_[k] < std::max({a[2], b[2], c[2]});
    }
    sums_.border += border;
    sums_.six_volumes += six_volumes;
    return hits;
  }

  void across(const Hit& hit) {
    const Grid corners = grid_ + 9 * hit.facet;
    const std::uint32_t* const hash = hashes_ + 3 * hit.facet;
    const std::array<Way, 2>& both = kWays[hit.order];
    const std::int32_t middle = corners[3 * both[0].middle + 2], high = corners[3 * both[0].high + 2];
    std::uint32_t k = hit.plane;
    std::int32_t z = planes_[k];
    do {
      const Way& way = both[z >= middle];
      Segment& s = lane_.add(k);
      s.from_edge = hash[way.from_low] + hash[way.from_high];
      s.to_edge = hash[way.to_low] + hash[way.to_high];
      s.from = crossing(corners + 3 * way.from_low, corners + 3 * way.from_high, z + 0.5);
      s.to = crossing(corners + 3 * way.to_low, corners + 3 * way.to_high, z + 0.5);
      z = planes_[++k];
    } while (z < high);
  }

  const PlaneFinder& planes_;
  SegmentLane& lane_;
  Sums& sums_;
  alignas(64) std::int32_t grid_[9 * kFacets];
  std::uint32_t hashes_[3 * kFacets];
  Hit hits_[kFacets + 1];
};

template <class Snap>
void cut_chunk(const FacetView& facets, const Affine& affine, std::size_t first, std::size_t end,
               Cutter& cutter, Sums& sums) {
  const Snap snap(affine);
  for (std::size_t n = first; n < end; n += Cutter::kFacets) {
    const std::size_t behind = std::min(end, n + Cutter::kFacets);
    const std::size_t count = snap_facets(facets, affine, snap, n, behind, cutter.grid());
    sums.not_finite += behind - n - count;
    cutter.cut(count);
  }
}

}  // namespace

std::vector<std::int32_t> layer_planes(double layer_height_mm, std::int32_t top) {
  const double height = layer_height_mm * geometry::kUnitsPerMm;
  if (!(std::isfinite(height) && height >= 10.0))
    throw std::invalid_argument("layer_height_mm = " + shortest_text(layer_height_mm) +
                                " must be 0.001 or more");
  constexpr int kMax = 1'000'000;
  if (double(top) / height > kMax)
    throw std::invalid_argument("layer_height_mm = " + shortest_text(layer_height_mm) +
                                " makes more than a million layers");
  std::vector<std::int32_t> planes;
  for (int n = 1;; ++n) {
    const double middle = std::floor((n - 0.5) * height);
    if (!(middle + 0.5 < double(top))) return planes;
    planes.push_back(std::int32_t(middle));
  }
}

Segments intersect(const FacetView& facets, const Affine& affine, std::span<const std::int32_t> planes,
                   const ParallelFor& parallel) {
  if (!std::is_sorted(planes.begin(), planes.end())) throw std::invalid_argument("planes must ascend");
  const PlaneFinder finder(planes);
  Segments out;
  out.store = std::make_unique<Segments::Store>();
  out.store->layers = planes.size();
  for (int lane = 0; lane < kWaveChunks; ++lane) out.store->lanes.emplace_back(planes.size());
  std::vector<Sums> sums(std::size_t(chunk_count(facets)));
  const auto& m = affine.matrix;
  const bool diagonal = m[1] == 0 && m[2] == 0 && m[3] == 0 && m[5] == 0 && m[6] == 0 && m[7] == 0;
  for_chunks(facets, Pass::kLast, parallel, [&](int chunk, std::size_t first, std::size_t end) {
    Sums mine;
    Cutter cutter(finder, out.store->lanes[std::size_t(chunk % kWaveChunks)], mine);
    (diagonal ? cut_chunk<Scaling> : cut_chunk<Turning>)(facets, affine, first, end, cutter, mine);
    sums[std::size_t(chunk)] = mine;
  });
  Sums total;
  for (const Sums& s : sums) total.add(s);
  MeshFacts& facts = out.facts;
  facts.facets = facets.size();
  facts.not_finite = total.not_finite;
  facts.degenerate = total.degenerate;
  facts.closed = total.border == 0 && facets.size() > total.not_finite;
  facts.volume_mm3 =
      double(total.six_volumes) / 6.0 * (geometry::kMmPerUnit * geometry::kMmPerUnit * geometry::kMmPerUnit);
  facts.coarse_mm = affine.coarse_mm;
  facts.low = affine.low;
  facts.high = affine.high;
  out.store->turned = facts.closed && total.six_volumes < 0;
  return out;
}

}  // namespace firn::slice
