#include "core/slice/exact_tips.h"

#include <algorithm>
#include <cmath>

namespace firn::slice {
namespace {

constexpr double kFurthest = 3.0 * kUnitsPerMm;  // tips that would move by more stay
constexpr double kFarOff = 16;                   // thinnings: walls so nearly parallel may close, or part, nearby
constexpr double kFound = 0.5;                   // units
constexpr int kSteps = 24;
// Feet move by more than the tip where a wall bends about it: so much of the distance is looked at to either side.
constexpr double kAround = 0.1;

}  // namespace

ExactTips::ExactTips(const Rings& contours) : contours_(contours) {
  const std::size_t n = contours.points.size();
  next_.resize(n);
  tree_.resize(n);
  std::size_t begin = 0;
  for (const std::uint32_t end : contours.ends) {
    for (std::size_t i = begin; i < end; ++i) {
      next_[i] = std::uint32_t(i + 1 < end ? i + 1 : begin);
      const Point a = contours.points[i], b = contours.points[next_[i]];
      tree_.set(i, std::min(a.x, b.x), std::min(a.y, b.y), std::max(a.x, b.x), std::max(a.y, b.y));
    }
    begin = end;
  }
  tree_.build();
}

// Edges about a wall's foot that run its way rather than the other's.
void ExactTips::look(const Wall& wall, const Wall& other, double reach, std::vector<Edge>& edges) const {
  edges.clear();
  tree_.touching(box_about(wall.foot.x, wall.foot.y, reach), [&](std::size_t i) {
    const Vec at = to_vec(contours_.points[i]), way = to_vec(contours_.points[next_[i]]) - at;
    const double ahead = dot(way, wall.along);
    if (ahead > 0 && ahead > dot(way, other.along)) edges.push_back({at, way, dot(way, way), 0});
  });
}

bool ExactTips::move(Vec& tip, const Wall& before, const Wall& after, double d) {
  const Vec was = tip;
  const bool found = find(tip, before, after, d);
  failed_ |= found && length(tip - was) > kFarOff * thinned_;
  failed_ |= !found && dot(before.along, after.along) < 0;
  return found;
}

// What is no further from a place that has moved by m was no further than 2 m more when the search began.
void ExactTips::list_close(int wall, double reach) {
  close_[wall].clear();
  const double square = (reach + 1) * (reach + 1);
  for (const Edge& e : edges_[wall])
    if (e.first_square <= square) close_[wall].push_back(e);
}

bool ExactTips::within(Vec place, double d) const {
  return !tree_.any_nearer(place.x, place.y, d, [&](std::size_t i) {
    return square_distance(place, to_vec(contours_.points[i]), to_vec(contours_.points[next_[i]])) < d * d;
  });
}

bool ExactTips::find(Vec& tip, const Wall& before, const Wall& after, double d) {
  // Walls' directions are a turn of pi - 2 a apart.
  const double sine = std::sqrt(std::max(0.0, 0.5 * (1 + dot(before.along, after.along))));
  const double furthest = std::min(kFurthest, 1.5 * thinned_ / std::max(sine, 1e-3) + thinned_);
  const double reach = furthest + 2 * thinned_ + kAround * d;
  look(before, after, reach, edges_[0]);
  look(after, before, reach, edges_[1]);
  if (edges_[0].empty() || edges_[1].empty()) return false;
  Vec p = tip;
  double first[2] = {}, within = -1;  // distances of the walls where the search begins; how far from there close_ holds
  for (int step = 0; step < kSteps; ++step) {
    const double moved = length(p - tip);
    const bool anew = step > 0 && moved > within;
    if (anew) within = 2 * moved;
    double lacks[2];
    Vec up[2];
    for (int w = 0; w < 2; ++w) {
      if (anew) list_close(w, first[w] + 2 * within);
      double nearest = 1e300;
      const Edge* found = nullptr;
      for (Edge& e : step > 0 ? close_[w] : edges_[w]) {
        const Vec off = e.from(p);
        const double s = dot(off, off);
        if (step == 0) e.first_square = s;
        if (s < nearest) nearest = s, found = &e;
      }
      if (!found) return false;
      up[w] = found->from(p);
      const double l = std::sqrt(nearest);
      if (step == 0) first[w] = l;
      if (l == 0) return false;
      up[w] = (1 / l) * up[w];
      lacks[w] = d - l;
    }
    if (std::abs(lacks[0]) < kFound && std::abs(lacks[1]) < kFound) {
      tip = p;
      return true;
    }
    const double det = cross(up[0], up[1]);
    if (std::abs(det) < 1e-4) return false;
    p = p + Vec{(lacks[0] * up[1].y - lacks[1] * up[0].y) / det, (lacks[1] * up[0].x - lacks[0] * up[1].x) / det};
    if (dot(p - tip, p - tip) > furthest * furthest) return false;
  }
  return false;
}

}  // namespace firn::slice
