// The offset oracle computes an offset by its definition, without the code of the slicer: the points whose
// distance from the outline, measured to every segment, is d.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::slice::oracle {

struct Segment {
  geometry::Vec a, b;
};

inline std::vector<Segment> segments_of(const geometry::Rings& rings) {
  std::vector<Segment> list;
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (std::size_t i = 0; i < rings[r].size(); ++i)
      list.push_back({to_vec(rings[r][i]), to_vec(rings[r][(i + 1) % rings[r].size()])});
  return list;
}

inline double distance(geometry::Vec p, const Segment& s) {
  const geometry::Vec way = s.b - s.a;
  const double square = dot(way, way), t = square > 0 ? std::clamp(dot(p - s.a, way) / square, 0.0, 1.0) : 0;
  return length(p - s.a - t * way);
}

/// Segments in buckets, for distances up to a reach.
class Nearby {
 public:
  Nearby(const std::vector<Segment>& segments, double reach) : segments_(segments), reach_(reach) {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Segment& s = segments[i];
      for (std::int64_t x = cell(std::min(s.a.x, s.b.x) - reach); x <= cell(std::max(s.a.x, s.b.x) + reach);
           ++x)
        for (std::int64_t y = cell(std::min(s.a.y, s.b.y) - reach); y <= cell(std::max(s.a.y, s.b.y) + reach);
             ++y)
          buckets_[key(x, y)].push_back(std::uint32_t(i));
    }
  }
  /// Exact up to the reach; anything larger means further.
  double distance_to(geometry::Vec p) const {
    double best = std::numeric_limits<double>::infinity();
    const auto found = buckets_.find(key(cell(p.x), cell(p.y)));
    if (found == buckets_.end()) return best;
    for (const std::uint32_t i : found->second) best = std::min(best, distance(p, segments_[i]));
    return best;
  }

 private:
  std::int64_t cell(double v) const { return std::int64_t(std::floor(v / (2 * reach_))); }
  static std::int64_t key(std::int64_t x, std::int64_t y) { return x * 1'000'003 + y; }
  std::vector<Segment> segments_;
  double reach_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> buckets_;
};

inline double distance_to_all(geometry::Vec p, const std::vector<Segment>& segments) {
  double best = std::numeric_limits<double>::infinity();
  for (const Segment& s : segments) best = std::min(best, distance(p, s));
  return best;
}

/// Places of the exact inward offset at distance d, at most `step` apart: candidates lie d away from one
/// segment or corner; those that no other segment is nearer to are on the offset.
inline std::vector<geometry::Vec> exact_offset(const geometry::Region& region, double d, double step) {
  const std::vector<Segment> segments = segments_of(region);
  std::vector<geometry::Vec> places;
  const Nearby nearby(segments, d + 1);
  const auto offer = [&](geometry::Vec p) {
    if (nearby.distance_to(p) >= d - 1e-4) places.push_back(p);
  };
  for (const Segment& s : segments) {
    const double l = length(s.b - s.a);
    if (l == 0) continue;
    const geometry::Vec along = (1 / l) * (s.b - s.a);
    const int n = int(std::ceil(l / step));
    for (int i = 0; i <= n; ++i) offer(s.a + (l * i / n) * along + d * left_of(along));
  }
  for (std::size_t r = 0; r < region.size(); ++r) {
    const auto ring = region[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const geometry::Vec before = to_vec(ring[i]) - to_vec(ring[(i + ring.size() - 1) % ring.size()]);
      const geometry::Vec after = to_vec(ring[(i + 1) % ring.size()]) - to_vec(ring[i]);
      if (cross(before, after) >= 0) continue;  // no arc about a convex corner
      const geometry::Vec n = left_of(before);
      const double from = std::atan2(n.y, n.x), turn = std::atan2(cross(before, after), dot(before, after));
      const int steps = int(std::ceil(std::abs(turn) * d / step));
      for (int k = 0; k <= steps; ++k) {
        const double a = from + turn * k / steps;
        offer(to_vec(ring[i]) + d * geometry::Vec{std::cos(a), std::sin(a)});
      }
    }
  }
  return places;
}

/// Points along rings, at most `step` apart.
inline std::vector<geometry::Vec> along(const geometry::Rings& rings, double step) {
  std::vector<geometry::Vec> places;
  for (const Segment& s : segments_of(rings)) {
    const int n = std::max(1, int(std::ceil(length(s.b - s.a) / step)));
    for (int i = 0; i < n; ++i) places.push_back(s.a + (double(i) / n) * (s.b - s.a));
  }
  return places;
}

/// Returns the distance of a point from one at distance d from the outline, up to `reach`, by points about
/// it: those where the distance passes d, or is d to within the grid. Finds parts of the offset that are too
/// small for samples along it.
inline double to_offset(const Nearby& outline, geometry::Vec p, double d, double reach) {
  const double here = outline.distance_to(p) - d;
  if (std::abs(here) <= 1) return 0;
  for (double r = 20; r < reach; r += 20)
    for (int k = 0; k < 32; ++k) {
      const double a = 2 * M_PI * k / 32,
                   there = outline.distance_to(p + r * geometry::Vec{std::cos(a), std::sin(a)}) - d;
      if ((there < 0) != (here < 0) || std::abs(there) <= 1) return r;
    }
  return std::numeric_limits<double>::infinity();
}

struct Hausdorff {
  double ring_to_exact = 0;  ///< furthest place of the rings from the exact offset, units
  double exact_to_ring = 0;
};

inline Hausdorff hausdorff(const geometry::Region& region, const geometry::Rings& rings, double d,
                           double step, double reach) {
  Hausdorff h;
  const std::vector<geometry::Vec> exact = exact_offset(region, d, step);
  std::vector<Segment> points;
  for (const geometry::Vec p : exact) points.push_back({p, p});
  const Nearby exact_near(points, reach), rings_near(segments_of(rings), reach),
      outline(segments_of(region), d + 2);
  for (const geometry::Vec p : along(rings, step)) {
    const double sampled = exact_near.distance_to(p);
    h.ring_to_exact = std::max(
        h.ring_to_exact, sampled <= step ? sampled : std::min(sampled, to_offset(outline, p, d, reach)));
  }
  for (const geometry::Vec p : exact) h.exact_to_ring = std::max(h.exact_to_ring, rings_near.distance_to(p));
  return h;
}

}  // namespace firn::slice::oracle
