#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kSmoothTurn =
    1e-3;  // sine of a turn below which two segments need no arc: d * turn^2 / 8 is < 0.01 um
constexpr double kSlack = 0.5;  // units by which a place of meeting may be off its curve

bool two_lines(const Source& a, const Source& b, Vec place, double d, Junction& junction) {
  const double sine = cross(a.along, b.along), cosine = dot(a.along, b.along);
  if (cosine > 0 ? sine < -kSmoothTurn : sine <= 0) return false;
  if (1 + cosine < 1e-9) return false;
  const Vec velocity = (1 / (1 + cosine)) * (left_of(a.along) + left_of(b.along));
  junction = {place, velocity};
  if (d == 0) return true;
  if (sine > kSmoothTurn)
    junction.base = a.at + (cross(b.at - a.at, b.along) / sine) * a.along;
  else
    junction.base = place - d * velocity;
  return true;
}

// `side` +1: the front goes from the corner to the line, -1: from the line to the corner.
bool line_and_corner(const Source& line, const Source& corner, double side, Vec place, Junction& junction) {
  if (side * dot(place - corner.at, line.along) < -kSlack) return false;
  const Vec normal = left_of(line.along);
  const double height = dot(corner.at - line.at, normal);
  const auto bow = side > 0 ? Junction::Kind::kParabolaAhead : Junction::Kind::kParabolaBack;
  if (height < 1e-3)
    junction = {corner.at, normal};
  else
    junction = {bow, corner.at - height * normal, side * line.along, height};
  return true;
}

bool two_corners(const Source& a, const Source& b, Vec place, Junction& junction) {
  const Vec between = b.at - a.at;
  const double distance = length(between);
  if (distance == 0) return false;
  junction = {Junction::Kind::kTwoCorners, 0.5 * (a.at + b.at), (1 / distance) * left_of(between),
              0.25 * distance * distance};
  return dot(place - junction.base, junction.direction) > -kSlack;
}

void add_loop(std::span<const Point> ring, std::vector<Source>& sides, std::vector<Source>& sources,
              Component& component) {
  if (ring.size() < 3) return;
  sides.clear();
  Vec at = to_vec(ring[0]);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec from = at;
    at = to_vec(ring[i + 1 == ring.size() ? 0 : i + 1]);
    const double l = length(at - from);
    if (l > 0) sides.push_back({from, (1 / l) * (at - from), l});
  }
  if (sides.size() < 3) return;
  const Source* last = &sides.back();
  for (const Source& here : sides) {
    const Source& before = *std::exchange(last, &here);
    Junction junction;
    if (!two_lines(before, here, here.at, 0, junction)) {
      // Half of the turn: the arc's middle looks along the sum of the normals, or back if the outline turns
      // round.
      Vec middle = before.along + here.along;
      const double l = length(middle);
      middle = l > 1e-9 ? (1 / l) * middle : right_of(before.along);
      component.pieces.push_back({{here.at, left_of(before.along)}, std::int32_t(sources.size()), here.at});
      sources.push_back({here.at, middle, -1});
      junction = {here.at, left_of(here.along)};
    }
    component.pieces.push_back({junction, std::int32_t(sources.size()), here.at});
    sources.push_back(here);
  }
  component.ends.push_back(std::uint32_t(component.pieces.size()));
}

}  // namespace

void front_of(const Region& region, std::span<const std::uint32_t> area, std::vector<Source>& sources,
              Components& components) {
  std::size_t points = 0;
  for (const std::uint32_t ring : area) points += region[ring].size();
  std::vector<Source> sides;
  sides.reserve(points);
  sources.reserve(sources.size() + 2 * points);
  Component& component = components.add();
  component.pieces.reserve(2 * points);
  for (const std::uint32_t ring : area) add_loop(region[ring], sides, sources, component);
}

bool meet(const Source& before, const Source& after, Vec place, double d, Junction& junction) {
  if (before.corner()) {
    return after.corner() ? two_corners(before, after, place, junction)
                          : line_and_corner(after, before, 1, place, junction);
  }
  return after.corner() ? line_and_corner(before, after, -1, place, junction)
                        : two_lines(before, after, place, d, junction);
}

}  // namespace firn::slice::wavefront
