#include "core/geometry/rings.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/geometry/planar.h"

namespace firn::geometry {
namespace {

// Returns whether the ring is smaller from i on than from j on.
bool smaller_from(std::span<const Point> ring, std::size_t i, std::size_t j) {
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Point &p = ring[(i + k) % ring.size()], &q = ring[(j + k) % ring.size()];
    if (p != q) return p < q;
  }
  return false;
}

// Returns a number that is ordered as points are.
std::uint64_t rank(const Point& p) {
  return (std::uint64_t(std::uint32_t(p.x)) << 32 | std::uint32_t(p.y)) ^ 0x8000000080000000u;
}

// Returns the index of the smallest point; if it occurs twice, the occurrence from which the ring is
// lexicographically smallest. @param repeats whether neighbours are equal
std::size_t beginning(std::span<const Point> ring, bool& repeats) {
  std::size_t first = 0;
  std::uint64_t before = rank(ring.back()), least = ~std::uint64_t(0);
  bool twice = false, equal = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::uint64_t now = rank(ring[i]);
    equal |= now == before;
    before = now;
    if (now > least) continue;
    twice = now == least;
    if (!twice) first = i;
    least = now;
  }
  repeats = equal;
  if (twice) {
    const Point smallest = ring[first];
    for (std::size_t i = first + 1; i < ring.size(); ++i)
      if (ring[i] == smallest && smaller_from(ring, i, first)) first = i;
  }
  return first;
}

void leave_out_repeated(std::vector<Point>& ring) {
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
}

// A ring read from one of its points on.
struct Begun {
  std::span<const Point> ring;
  std::size_t first;
  std::span<const Point> head() const { return ring.subspan(first); }
  std::span<const Point> tail() const { return ring.first(first); }
  const Point& operator[](std::size_t i) const {
    return ring[first + i < ring.size() ? first + i : first + i - ring.size()];
  }
  bool operator<(const Begun& o) const {
    const std::size_t common = std::min(ring.size(), o.ring.size());
    for (std::size_t i = 0; i < common; ++i)
      if ((*this)[i] != o[i]) return (*this)[i] < o[i];
    return ring.size() < o.ring.size();
  }
  void append(Rings& to) const {
    to.points.insert(to.points.end(), head().begin(), head().end());
    to.points.insert(to.points.end(), tail().begin(), tail().end());
    to.ends.push_back(std::uint32_t(to.points.size()));
  }
};

}  // namespace

void append_canonical(std::vector<Point>& ring, Rings& to) {
  leave_out_repeated(ring);
  bool repeats = false;
  if (ring.size() >= 3) Begun{ring, beginning(ring, repeats)}.append(to);
}

Rings sorted(Rings rings) {
  std::vector<Begun> order;
  order.reserve(rings.size());
  for (std::size_t r = 0; r < rings.size(); ++r) order.push_back({rings[r], 0});
  if (std::is_sorted(order.begin(), order.end())) return rings;
  std::sort(order.begin(), order.end());
  Rings out;
  out.points.reserve(rings.points.size());
  out.ends.reserve(rings.size());
  for (const Begun& r : order) r.append(out);
  return out;
}

Rings canonical(const Rings& rings) {
  std::vector<Begun> order;
  std::vector<std::vector<Point>> cleaned;  // of rings that could not be taken as they are
  order.reserve(rings.size());
  std::size_t points = 0;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    std::span<const Point> ring = rings[r];
    if (ring.size() < 3) continue;
    bool repeats = false;
    std::size_t first = beginning(ring, repeats);
    if (repeats) {
      leave_out_repeated(cleaned.emplace_back(ring.begin(), ring.end()));
      ring = cleaned.back();
      if (ring.size() < 3) continue;
      first = beginning(ring, repeats);
    }
    order.push_back({ring, first});
    points += ring.size();
  }
  std::sort(order.begin(), order.end());
  Rings out;
  out.points.reserve(points);
  out.ends.reserve(order.size());
  for (const Begun& r : order) r.append(out);
  return out;
}

}  // namespace firn::geometry
