// INTERSECTFACET [Barnett, 3.2], facet by facet: each is read once, measured, and leaves a segment in every plane that it
// crosses.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "core/slice/segments.h"
#include "core/slice/snap.h"

namespace firn::slice {
namespace {

/// First plane at or above a height, without a search: a table over z, then a step or two.
class PlaneFinder {
 public:
  explicit PlaneFinder(std::span<const std::int32_t> planes) : planes_(planes) {
    if (planes.empty()) return;
    base_ = planes.front();
    const std::int64_t range = std::int64_t(planes.back()) - base_;
    while ((range >> shift_) > std::int64_t(2 * planes.size())) ++shift_;
    table_.resize(std::size_t(range >> shift_) + 1);
    std::size_t k = 0;
    for (std::size_t i = 0; i < table_.size(); ++i) {
      while (planes[k] < base_ + (std::int64_t(i) << shift_)) ++k;
      table_[i] = std::uint32_t(k);
    }
  }
  std::size_t at_or_above(std::int32_t z) const {
    if (planes_.empty() || z <= base_) return 0;
    if (z > planes_.back()) return planes_.size();
    std::size_t k = table_[std::size_t((std::int64_t(z) - base_) >> shift_)];
    while (planes_[k] < z) ++k;
    return k;
  }

 private:
  std::span<const std::int32_t> planes_;
  std::int64_t base_ = 0;
  int shift_ = 0;
  std::vector<std::uint32_t> table_;
};

std::uint64_t hash(const Vertex& v) {
  std::uint64_t h = std::uint64_t(std::int64_t(v.x)) * 0x9e3779b97f4a7c15ull +
                    std::uint64_t(std::int64_t(v.y)) * 0xc2b2ae3d27d4eb4full +
                    std::uint64_t(std::int64_t(v.z)) * 0x165667b19e3779f9ull;
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93ull;
  return h ^ (h >> 29);
}

/// Crossings of one edge with planes, from its lower end up: the same for both facets of the edge.
struct EdgeLine {
  double x, y, z, slope_x, slope_y;
  EdgeLine(const Vertex& low, const Vertex& high) : x(low.x), y(low.y), z(low.z) {
    const double inverse = 1.0 / (double(high.z) - z);
    slope_x = (double(high.x) - x) * inverse;
    slope_y = (double(high.y) - y) * inverse;
  }
  Point at(double plane) const { return {to_grid(x + slope_x * (plane - z)), to_grid(y + slope_y * (plane - z))}; }
};

struct Sums {
  std::size_t not_finite = 0, degenerate = 0;
  std::uint64_t border = 0;  // 0 exactly when the edges cancel (docs/algorithms-slicing.md), but for chance 2^-60
  __int128 six_volumes = 0;
  void add(const Sums& s) {
    not_finite += s.not_finite;
    degenerate += s.degenerate;
    border += s.border;
    six_volumes += s.six_volumes;
  }
};

bool no_area(const Vertex& a, const Vertex& b, const Vertex& c) {
  const std::int64_t bx = std::int64_t(b.x) - a.x, by = std::int64_t(b.y) - a.y, bz = std::int64_t(b.z) - a.z;
  const std::int64_t cx = std::int64_t(c.x) - a.x, cy = std::int64_t(c.y) - a.y, cz = std::int64_t(c.z) - a.z;
  return bx * cy == by * cx && by * cz == bz * cy && bx * cz == bz * cx;
}

class Cutter {
 public:
  Cutter(std::span<const std::int32_t> planes, const PlaneFinder& finder, SegmentLane& lane, Sums& sums)
      : planes_(planes), finder_(finder), lane_(lane), sums_(sums) {}

  void cut(const Vertex& a, const Vertex& b, const Vertex& c) {
    const std::uint64_t ha = hash(a), hb = hash(b), hc = hash(c);
    // Each directed edge (a, b) adds a^2 b - a b^2, which its opposite takes away again.
    sums_.border += (ha - hb) * (hb - hc) * (hc - ha);
    const std::int64_t twice_shadow = (std::int64_t(b.x) - a.x) * (std::int64_t(c.y) - a.y) -
                                      (std::int64_t(c.x) - a.x) * (std::int64_t(b.y) - a.y);
    if (twice_shadow == 0 && no_area(a, b, c)) ++sums_.degenerate;
    sums_.six_volumes += __int128(twice_shadow) * (std::int64_t(a.z) + b.z + c.z);
    if (a == b || b == c || c == a) return;  // its two crossed edges are one: no way between them

    const End ends[3] = {{&a, ha}, {&b, hb}, {&c, hc}};
    const std::size_t k = finder_.at_or_above(std::min({a.z, b.z, c.z}));
    if (k == planes_.size() || planes_[k] >= std::max({a.z, b.z, c.z})) return;
    int low = 0, high = 0;
    for (int i = 1; i < 3; ++i) {
      if (ends[i].v->z < ends[low].v->z) low = i;
      if (ends[i].v->z >= ends[high].v->z) high = i;
    }
    across(k, ends[low], ends[3 - low - high], ends[high], (low + 1) % 3 != high);
  }

 private:
  struct End {
    const Vertex* v;
    std::uint64_t hash;
  };
  static std::uint32_t edge(const End& p, const End& q) { return std::uint32_t((p.hash >> 32) + (q.hash >> 32)); }

  // Seen from outside with z up, the middle corner of a facet whose corners run low, middle, high lies on the right, and
  // material to the left of a segment means that the segment runs to the right.
  void across(std::size_t k, const End& low, const End& middle, const End& high, bool rightward) {
    const EdgeLine rise(*low.v, *high.v);
    const std::uint32_t rise_edge = edge(low, high);
    const auto section = [&](const End& p, const End& q) {
      if (k == planes_.size() || planes_[k] >= q.v->z) return;
      const EdgeLine side(*p.v, *q.v);
      const std::uint32_t side_edge = edge(p, q);
      for (; k < planes_.size() && planes_[k] < q.v->z; ++k) {
        const double plane = planes_[k] + 0.5;
        Segment& s = lane_.add(k);
        const Point r = rise.at(plane), t = side.at(plane);
        s = rightward ? Segment{rise_edge, side_edge, r, t} : Segment{side_edge, rise_edge, t, r};
      }
    };
    section(low, middle);
    section(middle, high);
  }

  std::span<const std::int32_t> planes_;
  const PlaneFinder& finder_;
  SegmentLane& lane_;
  Sums& sums_;
};

/// Corners to the grid where the placement only scales and shifts: two numbers at a time.
class Scaling {
 public:
  explicit Scaling(const Affine& a) {
    for (std::size_t i = 0; i < 10; ++i) {
      const std::size_t axis = i % 3;
      factor_[i / 2][i % 2] = a.matrix[4 * axis];
      shift_[i / 2][i % 2] = a.shift[axis];
    }
  }
  std::array<Vertex, 3> operator()(const std::array<Corner, 3>& f) const {
    float numbers[10] = {};
    std::memcpy(numbers, f.data(), sizeof f);
    std::int32_t grid[12];
    for (std::size_t i = 0; i < 5; ++i) {
      const Pair pair = {numbers[2 * i], numbers[2 * i + 1]};
      const Pair sum = (pair * factor_[i] + shift_[i]) + kRounding;
      const Words words = std::bit_cast<Words>(sum);
      grid[2 * i] = words[0];
      grid[2 * i + 1] = words[2];
    }
    return {{{grid[0], grid[1], grid[2]}, {grid[3], grid[4], grid[5]}, {grid[6], grid[7], grid[8]}}};
  }

 private:
  using Pair = double __attribute__((vector_size(16)));
  using Words = std::int32_t __attribute__((vector_size(16)));
  Pair factor_[5], shift_[5];
};

class Turning {
 public:
  explicit Turning(const Affine& a) : affine_(a) {}
  std::array<Vertex, 3> operator()(const std::array<Corner, 3>& f) const {
    return {to_grid(affine_, f[0]), to_grid(affine_, f[1]), to_grid(affine_, f[2])};
  }

 private:
  const Affine& affine_;
};

template <class Snap>
void cut_chunk(const FacetView& facets, const Affine& affine, std::size_t first, std::size_t end, Cutter& cutter, Sums& sums) {
  const Snap snap(affine);
  const std::size_t second = affine.mirrors ? 2 : 1;
  for (std::size_t n = first; n < end; ++n) {
    const std::array<Corner, 3> f = facets.facet(n);
    if (affine.not_finite && !finite(f)) {
      ++sums.not_finite;
      continue;
    }
    const std::array<Vertex, 3> v = snap(f);
    cutter.cut(v[0], v[second], v[3 - second]);
  }
}

}  // namespace

std::vector<std::int32_t> layer_planes(double layer_height_mm, std::int32_t top) {
  const double height = layer_height_mm * kUnitsPerMm;
  if (!(std::isfinite(height) && height >= 10.0))
    throw std::invalid_argument("layer_height_mm = " + std::to_string(layer_height_mm) + " must be 0.001 or more");
  constexpr int kMost = 1'000'000;
  if (double(top) / height > kMost)
    throw std::invalid_argument("layer_height_mm = " + std::to_string(layer_height_mm) + " makes more than a million layers");
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
  for_chunks(facets, parallel, [&](int chunk, std::size_t first, std::size_t end) {
    Sums mine;
    Cutter cutter(planes, finder, out.store->lanes[std::size_t(chunk % kWaveChunks)], mine);
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
  facts.volume_mm3 = double(total.six_volumes) / 6.0 * (kMmPerUnit * kMmPerUnit * kMmPerUnit);
  facts.low = affine.low;
  facts.high = affine.high;
  out.store->turned = facts.closed && total.six_volumes < 0;
  return out;
}

}  // namespace firn::slice
