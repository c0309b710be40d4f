#include "core/slice/rings.h"

#include <algorithm>
#include <numeric>

#include "core/slice/planar.h"

namespace firn::slice {
namespace {

// Is the ring, begun at i, smaller than begun at j?
bool smaller_from(const std::vector<Point>& ring, std::size_t i, std::size_t j) {
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Point &p = ring[(i + k) % ring.size()], &q = ring[(j + k) % ring.size()];
    if (p != q) return p < q;
  }
  return false;
}

}  // namespace

void append_canonical(std::vector<Point>& ring, Rings& to) {
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
  if (ring.size() < 3) return;
  std::size_t first = 0;
  bool twice = false;
  for (std::size_t i = 1; i < ring.size(); ++i) {
    if (ring[i] < ring[first]) {
      first = i;
      twice = false;
    } else if (ring[i] == ring[first]) {
      twice = true;
    }
  }
  if (twice) {
    const Point smallest = ring[first];
    for (std::size_t i = first + 1; i < ring.size(); ++i)
      if (ring[i] == smallest && smaller_from(ring, i, first)) first = i;
  }
  to.points.insert(to.points.end(), ring.begin() + std::ptrdiff_t(first), ring.end());
  to.points.insert(to.points.end(), ring.begin(), ring.begin() + std::ptrdiff_t(first));
  to.ends.push_back(std::uint32_t(to.points.size()));
}

Rings sorted(const Rings& rings) {
  std::vector<std::size_t> order(rings.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  const auto before = [&](std::size_t a, std::size_t b) {
    const auto p = rings[a], q = rings[b];
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  };
  if (std::is_sorted(order.begin(), order.end(), before)) return rings;
  std::sort(order.begin(), order.end(), before);
  Rings out;
  out.points.reserve(rings.points.size());
  out.ends.reserve(rings.size());
  for (const std::size_t r : order) out.add(rings[r]);
  return out;
}

Rings canonical(const Rings& rings) {
  Rings out;
  out.points.reserve(rings.points.size());
  std::vector<Point> ring;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    ring.assign(rings[r].begin(), rings[r].end());
    append_canonical(ring, out);
  }
  return sorted(out);
}

}  // namespace firn::slice
