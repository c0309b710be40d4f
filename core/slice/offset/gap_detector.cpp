#include "core/slice/offset/gap_detector.h"

#include <algorithm>

#include "core/geometry/box.h"

namespace firn::slice::wavefront {
namespace {

// Appends points of the arc strictly between a and b (relative to the centre, at distance d) by bisection
// until chords are near it.
void halve(geometry::Vec centre, double d, geometry::Vec a, geometry::Vec b, double least,
           std::vector<geometry::Vec>& points) {
  const geometry::Vec sum = a + b;
  const double l = length(sum);
  if (l >= 2 * least || l <= 0) return;
  const geometry::Vec middle = (d / l) * sum;
  halve(centre, d, a, middle, least, points);
  points.push_back(centre + middle);
  halve(centre, d, middle, b, least, points);
}

void add_place(geometry::Vec p, std::size_t begin, std::vector<geometry::Vec>& points) {
  const double same = 1e-6;  // units
  if (points.size() == begin || dot(p - points.back(), p - points.back()) > same) points.push_back(p);
}

}  // namespace

void GapDetector::keep(const Component& component, double d) {
  d_ = d;
  kept_.resize(component.edges.size());
  for (std::size_t i = 0; i < kept_.size(); ++i)
    kept_[i] = {component.edges[i].site, component.edges[i].from};
  ends_ = component.ends;
}

void GapDetector::find(std::span<const Site> sites, std::span<const Component> out,
                       const CoverageGapLimits& limits, double sagitta, geometry::BoundaryChains& chains) {
  sites_ = sites;
  at_.resize(sites.size(), kGone);
  std::size_t edges = 0;
  for (const Component& component : out) edges += component.edges.size();
  ahead_.resize(edges);
  std::size_t here = 0;
  for (const Component& component : out) {
    std::size_t i = 0;
    for (const std::uint32_t end : component.ends) {
      const std::size_t first = here;
      for (; i < end; ++i, ++here) {
        const WavefrontEdge& edge = component.edges[i];
        ahead_[here] = {edge.from, edge.site, std::int32_t(here + 1)};
        std::int32_t& at = at_[std::size_t(edge.site)];
        at = at == kGone ? std::int32_t(here) : kSeveral;
      }
      if (here > first) ahead_[here - 1].next = std::int32_t(first);
    }
  }
  const std::size_t before = chains.all.size();
  std::size_t begin = 0;
  loop_vanished_ = false;
  for (const std::uint32_t end : ends_) {
    const auto lives = [&](const Kept& edge) { return at_[std::size_t(edge.site)] >= 0; };
    loop_vanished_ = loop_vanished_ || std::none_of(kept_.begin() + begin, kept_.begin() + end, lives);
    begin = end;
  }
  begin = 0;
  for (const std::uint32_t end : ends_) {
    find_in(std::span(kept_).subspan(begin, end - begin), limits, sagitta, chains);
    begin = end;
  }
  if (chains.all.size() > before) chains.all[before].leads = true;
  for (const Ahead& edge : ahead_) at_[std::size_t(edge.site)] = kGone;
}

void GapDetector::find_in(std::span<const Kept> loop, const CoverageGapLimits& limits, double sagitta,
                          geometry::BoundaryChains& chains) {
  const std::size_t n = loop.size();
  std::size_t first = 0;
  while (first < n && at_[std::size_t(loop[first].site)] < 0) ++first;
  if (first == n) {
    add_all(loop, limits, sagitta, chains);
    return;
  }
  const double near = loop_vanished_ ? limits.near : limits.far, square = near * near;
  std::int32_t a = at_[std::size_t(loop[first].site)];
  for (std::size_t i = first, walked = 0; walked < n;) {
    std::size_t j = i + 1 < n ? i + 1 : 0, steps = 1;
    std::int32_t b = at_[std::size_t(loop[j].site)];
    if (b >= 0 && ahead_[std::size_t(a)].next == b) {  // nearly always
      const geometry::Vec off = loop[j].from - ahead_[std::size_t(b)].from;
      if (dot(off, off) <= square) {
        i = j;
        a = b;
        ++walked;
        continue;
      }
    }
    for (; b < 0; ++steps) {
      j = j + 1 < n ? j + 1 : 0;
      b = at_[std::size_t(loop[j].site)];
    }
    if (!covered(loop, i, steps, limits)) add_chain(loop, i, steps, sagitta, chains);
    i = j;
    a = b;
    walked += steps;
  }
}

// Returns whether the part between edge i and the one `steps` further, both alive, is near the corner in
// which they now meet.
bool GapDetector::covered(std::span<const Kept> loop, std::size_t i, std::size_t steps,
                          const CoverageGapLimits& limits) const {
  const std::size_t n = loop.size(), j = i + steps < n ? i + steps : i + steps - n;
  const std::int32_t a = at_[std::size_t(loop[i].site)], b = at_[std::size_t(loop[j].site)];
  if (ahead_[std::size_t(a)].next != b) return false;
  const geometry::Vec corner = ahead_[std::size_t(b)].from;
  const double near = cornered(loop, i, steps) ? limits.far : limits.near;
  bool all_near = true;
  for (std::size_t k = i, s = 0; s < steps && all_near; ++s) {
    k = k + 1 < n ? k + 1 : 0;
    const geometry::Vec off = loop[k].from - corner;
    const Site& site = sites_[std::size_t(loop[k].site)];
    // An arc that bulges away may extend further than its ends.
    all_near = dot(off, off) <= near * near &&
               (s + 1 == steps || !site.corner() || dot(corner - site.at, site.along) >= 0);
  }
  return all_near || blunt(loop, i, steps, corner, limits);
}

// Returns whether the part between the two lies within the corner that they would form, and whether that
// corner is too blunt for a void.
bool GapDetector::blunt(std::span<const Kept> loop, std::size_t i, std::size_t steps, geometry::Vec corner,
                        const CoverageGapLimits& limits) const {
  const std::size_t n = loop.size(), j = i + steps < n ? i + steps : i + steps - n;
  const geometry::Vec to_a = corner - beside(loop[i], corner), to_c = corner - beside(loop[j], corner);
  const double way = length(to_a), sum = length(to_a + to_c);
  // The corner that two sides form is way / sin(half their angle) from the point at distance `way` from both.
  if (cross(to_a, to_c) <= 0 || 2 * way * way > sum * limits.near_corner) return false;
  const double outside = -(way + limits.slack) * way, furthest = limits.near_corner + limits.slack;
  for (std::size_t k = i, s = 0; s < steps; ++s) {
    k = k + 1 < n ? k + 1 : 0;
    const geometry::Vec off = loop[k].from - corner;
    if (dot(off, to_a) < outside || dot(off, to_c) < outside || dot(off, off) > furthest * furthest)
      return false;
  }
  return true;
}

bool GapDetector::cornered(std::span<const Kept> loop, std::size_t i, std::size_t steps) const {
  const std::size_t n = loop.size(), j = i + steps < n ? i + steps : i + steps - n;
  const std::int32_t a = at_[std::size_t(loop[i].site)], b = at_[std::size_t(loop[j].site)];
  if (loop_vanished_ || a == b || ahead_[std::size_t(a)].next != b) return false;
  for (std::size_t k = i, s = 1; s < steps; ++s) {
    k = k + 1 < n ? k + 1 : 0;
    if (at_[std::size_t(loop[k].site)] != kGone) return false;
  }
  return true;
}

// Returns the point of a stored edge beside a point of the next edge of the same site.
geometry::Vec GapDetector::beside(const Kept& edge, geometry::Vec ahead) const {
  const Site& site = sites_[std::size_t(edge.site)];
  const geometry::Vec off = ahead - site.at;
  if (!site.corner()) return site.at + dot(off, site.along) * site.along + d_ * left_of(site.along);
  const double l = length(off);
  return l > 0 ? site.at + (d_ / l) * off : edge.from;
}

void GapDetector::add_arc(const Kept& edge, geometry::Vec a, geometry::Vec b, double sagitta,
                          std::vector<geometry::Vec>& points) const {
  const Site& site = sites_[std::size_t(edge.site)];
  if (site.corner() && d_ > sagitta) halve(site.at, d_, a - site.at, b - site.at, d_ - sagitta, points);
}

void GapDetector::add_chain(std::span<const Kept> loop, std::size_t i, std::size_t steps, double sagitta,
                            geometry::BoundaryChains& chains) {
  const std::size_t n = loop.size(), begin = chains.points.size();
  const auto after = [&](std::size_t k) { return k + 1 < n ? k + 1 : 0; };
  const std::size_t j = i + steps < n ? i + steps : i + steps - n;
  const std::int32_t a = at_[std::size_t(loop[i].site)], b = at_[std::size_t(loop[j].site)];
  const geometry::Vec from = beside(loop[i], ahead_[std::size_t(ahead_[std::size_t(a)].next)].from);
  const geometry::Vec to = beside(loop[j], ahead_[std::size_t(b)].from);
  std::vector<geometry::Vec>& points = chains.points;
  if (points.capacity() == 0) {
    points.reserve(256);
    chains.all.reserve(32);
  }
  add_place(loop[i].from, begin, points);
  add_place(from, begin, points);
  const std::uint32_t first = std::uint32_t(points.size() - 1 - begin);
  geometry::Vec at = from;
  for (std::size_t k = i, s = 0; s < steps; ++s) {
    const geometry::Vec end = loop[after(k)].from;
    add_arc(loop[k], at, end, sagitta, points);
    add_place(end, begin, points);
    k = after(k);
    at = end;
  }
  add_arc(loop[j], at, to, sagitta, points);
  add_place(to, begin, points);
  const std::uint32_t last = std::uint32_t(points.size() - 1 - begin);
  add_place(loop[after(j)].from, begin, points);
  if (last == first)
    points.resize(begin);
  else
    chains.all.push_back({std::uint32_t(points.size()), first, last, false, cornered(loop, i, steps),
                          ahead_[std::size_t(b)].from, false});
}

void GapDetector::add_all(std::span<const Kept> loop, const CoverageGapLimits& limits, double sagitta,
                          geometry::BoundaryChains& chains) const {
  const std::size_t n = loop.size(), begin = chains.points.size();
  geometry::BoxOf<double> box;
  double twice_area = 0;
  for (std::size_t i = 0; i < n; ++i) {
    box.add(loop[i].from.x, loop[i].from.y);
    twice_area += cross(loop[i].from - loop[0].from, loop[i + 1 < n ? i + 1 : 0].from - loop[0].from);
  }
  // Arcs bulge inward, and no disc of the minimum size fits into a loop this small.
  if (twice_area > 0 && std::min(box.x1 - box.x0, box.y1 - box.y0) < limits.narrowest) return;
  std::vector<geometry::Vec>& points = chains.points;
  for (std::size_t i = 0; i < n; ++i) {
    const geometry::Vec end = loop[i + 1 < n ? i + 1 : 0].from;
    add_place(loop[i].from, begin, points);
    add_arc(loop[i], loop[i].from, end, sagitta, points);
  }
  while (points.size() > begin + 1 && dot(points.back() - points[begin], points.back() - points[begin]) < 1)
    points.pop_back();
  if (points.size() < begin + 3)
    points.resize(begin);
  else
    chains.all.push_back(
        {std::uint32_t(points.size()), 0, std::uint32_t(points.size() - begin), true, false, {}, false});
}

}  // namespace firn::slice::wavefront
