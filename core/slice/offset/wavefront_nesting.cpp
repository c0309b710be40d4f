#include <algorithm>

#include "core/geometry/point_measures.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {
namespace {

// Calls f for the corners of a loop and the middles of its arcs, which suffice for its orientation and for
// containment tests.
template <class F>
void each_corner(std::span<const Site> sites, std::span<const WavefrontEdge> edges, double d, F&& f) {
  for (std::size_t i = 0; i < edges.size(); ++i) {
    f(edges[i].from);
    const Site& site = sites[std::size_t(edges[i].site)];
    if (site.corner()) f(middle(site, edges[i].from, edges[i + 1 < edges.size() ? i + 1 : 0].from, d));
  }
}

// Returns twice the area of a loop; of its chords alone where arcs cannot change the sign.
double area(std::span<const Site> sites, std::span<const WavefrontEdge> edges, double d) {
  const geometry::Vec origin = edges[0].from;
  double sum = 0, edge = 0, longest = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const geometry::Vec a = edges[i].from, b = edges[i + 1 < edges.size() ? i + 1 : 0].from, way = b - a;
    sum += cross(a - origin, b - origin);
    edge += std::abs(way.x) + std::abs(way.y);
    longest = std::max(longest, dot(way, way));
  }
  // The area between an arc of at most half a turn and its chord c is less than c^3 / 5 d.
  if (5 * d * std::abs(sum) > 2 * longest * edge) return sum;
  sum = 0;
  geometry::Vec before;
  each_corner(sites, edges, d, [&](geometry::Vec corner) {
    const geometry::Vec here = corner - origin;
    sum += cross(before, here);
    before = here;
  });
  return sum;
}

}  // namespace

geometry::Vec middle(const Site& site, geometry::Vec a, geometry::Vec b, double d) {
  if (!site.corner()) return 0.5 * (a + b);
  const geometry::Vec sum = (a - site.at) + (b - site.at);
  const double l = length(sum);
  return l > 0 ? site.at + (d / l) * sum : a;
}

void HoleNesting::operator()(std::span<const Site> sites, Components& loops, double d, Components& out) {
  areas_.clear();
  outers_.clear();
  for (const Component& loop : loops.all()) {
    areas_.push_back(area(sites, loop.edges, d));
    if (areas_.back() > 0) outers_.push_back(areas_.size() - 1);
  }
  const std::span<Component> all = loops.all();
  if (outers_.size() < all.size()) {
    list_holes(sites, all, d);
    for (std::size_t hole = 0; hole < all.size(); ++hole) {
      if (outer_of_[hole] == kNone) continue;
      Component& outer = all[outer_of_[hole]];
      outer.edges.insert(outer.edges.end(), all[hole].edges.begin(), all[hole].edges.end());
      outer.ends.push_back(std::uint32_t(outer.edges.size()));
    }
  }
  for (const std::size_t outer : outers_) out.take(all[outer]);
}

// Assigns each hole to the smallest outer loop that contains it; of equal ones to the first.
void HoleNesting::list_holes(std::span<const Site> sites, std::span<const Component> loops, double d) {
  outer_of_.assign(loops.size(), kNone);
  if (outers_.size() > 1) {
    corners_.resize(std::max(corners_.size(), outers_.size()));
    boxes_.resize(outers_.size());
    for (std::size_t o = 0; o < outers_.size(); ++o) {
      corners_[o].clear();
      geometry::BoxOf<double> box;
      each_corner(sites, loops[outers_[o]].edges, d, [&](geometry::Vec corner) {
        corners_[o].push_back(corner);
        box.add(corner.x, corner.y);
      });
      boxes_.set(o, geometry::floor_of(box.x0), geometry::floor_of(box.y0), geometry::floor_of(box.x1) + 1,
                 geometry::floor_of(box.y1) + 1);
    }
    boxes_.build();
  }
  for (std::size_t hole = 0; hole < loops.size(); ++hole) {
    if (areas_[hole] > 0) continue;
    std::size_t& outer = outer_of_[hole];
    if (outers_.size() == 1) outer = outers_[0];
    if (outers_.size() < 2) continue;
    const geometry::Vec at = loops[hole].edges[0].from;
    boxes_.touching(geometry::box_about(at.x, at.y, 0), [&](std::size_t o) {
      if ((outer == kNone || areas_[outers_[o]] < areas_[outer]) && encloses<geometry::Vec>(corners_[o], at))
        outer = outers_[o];
    });
  }
}

}  // namespace firn::slice::wavefront
