#include "core/slice/offset/topology_check.h"

#include <algorithm>

#include "core/geometry/vec.h"

namespace firn::slice {
namespace {

constexpr double kCusp =
    40;  // simplifications along a ring: edges no further apart face each other across a cusp
constexpr double kEvery = 2;  // simplifications: distance between tested points
constexpr int kAcross = 4;    // divisions of the distance across

class NarrowPassages {
 public:
  NarrowPassages(const geometry::Rings& rings, const geometry::IntersectionCheck& checked, double facing,
                 double d, CuspCorrector& cusps)
      : rings_(rings), checked_(checked), facing_(facing), d_(d), cusps_(cusps) {}

  // Lists the points between two edges that are nowhere d from the contours.
  void look_between(geometry::IntersectionCheck::Pair pair) const {
    if (follows_soon(pair.one, pair.other) || follows_soon(pair.other, pair.one)) return;
    const geometry::Vec a = from(pair.one), along = to(pair.one) - a, c = from(pair.other),
                        way = to(pair.other) - c;
    const double square = dot(along, along);
    const int steps = 1 + int(length(way) / (kEvery * cusps_.simplified()));
    for (int s = 0; s <= steps; ++s) {
      const geometry::Vec p = c + (double(s) / steps) * way, off = p - a;
      const geometry::Vec across = a + (std::clamp(dot(off, along), 0.0, square) / square) * along - p;
      if (cross(along, off) > 0 && dot(across, across) <= facing_ * facing_ && !open(p, across))
        cusps_.uncertain().add(p, d_);
    }
  }

  // Examines a ring that is too small for passages.
  void look_into(std::span<const geometry::Point> ring) const {
    double around = 0;
    geometry::Vec middle, at = to_vec(ring.back());
    for (const geometry::Point p : ring) {
      const geometry::Vec next = to_vec(p);
      around += length(next - at);
      if (around > 2 * kCusp * cusps_.simplified()) return;
      middle = middle + next;
      at = next;
    }
    middle = (1.0 / double(ring.size())) * middle;
    const auto is_open = [&](geometry::Vec p) { return cusps_.within(p, d_); };
    if (cusps_.uncertain().resolved(middle, d_) || is_open(middle)) return;
    if (std::none_of(ring.begin(), ring.end(),
                     [&](geometry::Point p) { return is_open(0.5 * (middle + to_vec(p))); }))
      cusps_.uncertain().add(middle, d_);
  }

 private:
  geometry::Vec from(std::uint32_t edge) const { return to_vec(rings_.points[edge]); }
  geometry::Vec to(std::uint32_t edge) const { return from(checked_.next(edge)); }
  bool follows_soon(std::uint32_t edge, std::uint32_t other) const {
    for (double way = 0; way < kCusp * cusps_.simplified(); way += length(to(edge) - from(edge)))
      if (edge = checked_.next(edge); edge == other) return true;
    return false;
  }
  bool open(geometry::Vec p, geometry::Vec across) const {
    if (cusps_.uncertain().resolved(p, d_)) return true;
    for (int k = 0; k <= kAcross; ++k)
      if (cusps_.within(p + (double(k) / kAcross) * across, d_)) return true;
    return false;
  }

  const geometry::Rings& rings_;
  const geometry::IntersectionCheck& checked_;
  double facing_, d_;
  CuspCorrector& cusps_;
};

}  // namespace

void check_topology(const geometry::Rings& rings, const geometry::IntersectionCheck& checked, double facing,
                    std::span<const geometry::Vec> peaks, double d, CuspCorrector& cusps) {
  for (const geometry::Vec p : peaks)
    if (!cusps.uncertain().resolved(p, d) && cusps.within(p, d - cusps.simplified()))
      cusps.uncertain().add(p, d);
  const NarrowPassages passages(rings, checked, facing, d, cusps);
  for (std::size_t r = 0; r < rings.size(); ++r) passages.look_into(rings[r]);
  for (const geometry::IntersectionCheck::Pair pair : checked.facing()) passages.look_between(pair);
}

}  // namespace firn::slice
