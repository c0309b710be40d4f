#include "core/slice/offset/wavefront.h"

#include <algorithm>

namespace firn::slice::wavefront {
namespace {

// Sine of a turn below which two segments need no arc: d * turn^2 / 8 is < 0.01 um.
constexpr double kSmoothTurn = 1e-3;
constexpr double kSlack = 0.5;  // units by which a meeting point may be off its curve

bool two_lines(const Site& a, const Site& b, geometry::Vec place, double d, Bisector& bisector) {
  const double sine = cross(a.along, b.along), cosine = dot(a.along, b.along);
  if (cosine > 0 ? sine < -kSmoothTurn : sine <= 0) return false;
  if (1 + cosine < 1e-9) return false;
  const geometry::Vec velocity = (1 / (1 + cosine)) * (left_of(a.along) + left_of(b.along));
  bisector = {place, velocity};
  if (d == 0) return true;
  if (sine > kSmoothTurn)
    bisector.base = a.at + (cross(b.at - a.at, b.along) / sine) * a.along;
  else
    bisector.base = place - d * velocity;
  return true;
}

// `side` +1: the wavefront leads from the corner to the line, -1: from the line to the corner.
bool line_and_corner(const Site& line, const Site& corner, double side, geometry::Vec place,
                     Bisector& bisector) {
  if (side * dot(place - corner.at, line.along) < -kSlack) return false;
  const geometry::Vec normal = left_of(line.along);
  const double height = dot(corner.at - line.at, normal);
  const auto bow = side > 0 ? Bisector::Kind::kParabolaAhead : Bisector::Kind::kParabolaBack;
  if (height < 1e-3)
    bisector = {corner.at, normal};
  else
    bisector = {bow, corner.at - height * normal, side * line.along, height};
  return true;
}

bool two_corners(const Site& a, const Site& b, geometry::Vec place, Bisector& bisector) {
  const geometry::Vec between = b.at - a.at;
  const double distance = length(between);
  if (distance == 0) return false;
  bisector = {Bisector::Kind::kTwoCorners, 0.5 * (a.at + b.at), (1 / distance) * left_of(between),
              0.25 * distance * distance};
  return dot(place - bisector.base, bisector.direction) > -kSlack;
}

void add_loop(std::span<const geometry::Point> ring, std::vector<Site>& sides, std::vector<Site>& sites,
              Component& component) {
  if (ring.size() < 3) return;
  sides.clear();
  geometry::Vec at = to_vec(ring[0]);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const geometry::Vec from = at;
    at = to_vec(ring[i + 1 == ring.size() ? 0 : i + 1]);
    const double l = length(at - from);
    if (l > 0) sides.push_back({from, (1 / l) * (at - from), l});
  }
  if (sides.size() < 3) return;
  const Site* last = &sides.back();
  for (const Site& here : sides) {
    const Site& before = *std::exchange(last, &here);
    Bisector bisector;
    if (!two_lines(before, here, here.at, 0, bisector)) {
      // Half of the turn: the middle of the arc has the direction of the sum of the normals, or the reverse
      // direction if the outline turns back.
      geometry::Vec middle = before.along + here.along;
      const double l = length(middle);
      middle = l > 1e-9 ? (1 / l) * middle : right_of(before.along);
      component.edges.push_back({{here.at, left_of(before.along)}, std::int32_t(sites.size()), here.at});
      sites.push_back({here.at, middle, -1});
      bisector = {here.at, left_of(here.along)};
    }
    component.edges.push_back({bisector, std::int32_t(sites.size()), here.at});
    sites.push_back(here);
  }
  component.ends.push_back(std::uint32_t(component.edges.size()));
}

}  // namespace

void wavefront_of(const geometry::Region& region, std::span<const std::uint32_t> area,
                  std::vector<Site>& sites, Components& components) {
  std::size_t points = 0;
  for (const std::uint32_t ring : area) points += region[ring].size();
  std::vector<Site> sides;
  sides.reserve(points);
  // An exact reserve for each area of many would copy all sites each time.
  if (const std::size_t most = sites.size() + 2 * points; most > sites.capacity())
    sites.reserve(std::max(most, 2 * sites.capacity()));
  Component& component = components.add();
  component.edges.reserve(2 * points);
  for (const std::uint32_t ring : area) add_loop(region[ring], sides, sites, component);
}

bool bisector_of(const Site& before, const Site& after, geometry::Vec place, double d, Bisector& bisector) {
  if (before.corner()) {
    return after.corner() ? two_corners(before, after, place, bisector)
                          : line_and_corner(after, before, 1, place, bisector);
  }
  return after.corner() ? line_and_corner(before, after, -1, place, bisector)
                        : two_lines(before, after, place, d, bisector);
}

}  // namespace firn::slice::wavefront
