#include "core/slice/offset/cusp_corrector.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace firn::slice {
namespace {

constexpr double kFurthest = 3.0 * geometry::kUnitsPerMm;  // cusps that would move by more are not corrected
constexpr double kFarOff =
    16;  // simplifications: a cusp that moves by more may close or open passages on its way
constexpr double kNarrow = -0.95;  // cosine of the turn at a cusp whose sides are nearly parallel
constexpr double kEvery = 2;       // simplifications: distance between tests
constexpr double kFound = 0.5;     // units
constexpr int kSteps = 24;
// The nearest points of a cusp on its sides move further than the cusp if a side is curved: this share of the
// distance is searched to both sides.
constexpr double kAround = 0.1;

}  // namespace

void CuspCorrector::take(const geometry::Rings& contours) {
  points_ = contours.points;
  uncertain_.forget();
  const std::size_t n = contours.points.size();
  next_.resize(n);
  std::iota(next_.begin(), next_.end(), 1u);
  tree_.set_rings(contours);
  std::size_t begin = 0;
  for (const std::uint32_t end : contours.ends) {
    if (end > begin) next_[end - 1] = std::uint32_t(begin);
    begin = end;
  }
  tree_.build();
}

// Collects the edges about the nearest point of a side whose direction is that of this side rather than of
// the other one.
void CuspCorrector::look(const Side& side, const Side& other, double reach, EdgeBatch& edges) const {
  edges.clear();
  tree_.eights_touching(geometry::box_about(side.foot.x, side.foot.y, reach),
                        [&](std::size_t first, unsigned met) {
                          edges.add(points_, next_.data(), first, met, side.along, other.along);
                        });
}

bool CuspCorrector::move(geometry::Vec& cusp, const Side& before, const Side& after, double d) {
  if (uncertain_.exact(cusp, d)) return false;
  const geometry::Vec was = cusp;
  const bool found = find(cusp, before, after, d);
  if (!lists_uncertain_) return found;
  if (dot(before.along, after.along) < kNarrow) {
    const geometry::Vec outward = 0.5 * (before.along - after.along);
    const double far = furthest(before, after) - length(cusp - was);
    look_along(cusp, outward, far, 1, d);
    look_along(cusp, -1 * outward, far, -1, d);
  }
  if (!found && dot(before.along, after.along) < 0) uncertain_.add(cusp, d);
  if (const double way = length(cusp - was); way > kFarOff * simplified_) {
    const int steps = 1 + int(way / uncertain_.spacing());
    for (int k = 0; k <= steps; ++k) uncertain_.add(was + (double(k) / steps) * (cusp - was), d);
  }
  return found;
}

// Nearly parallel sides may open again beyond a cusp by no more than the simplification, and close before it.
// @param closes +1: beyond it, -1: before it
void CuspCorrector::look_along(geometry::Vec cusp, geometry::Vec direction, double far, double closes,
                               double d) {
  if (edges_[0].empty() || edges_[1].empty()) return;
  const double step = kEvery * simplified_;
  for (double way = step; way < far; way += step) {
    geometry::Vec p = cusp + way * direction, up;
    double off = 0;
    for (int centring = 0; centring < 2; ++centring) {
      double l[2];
      for (int w = 0; w < 2; ++w) {
        const geometry::Vec nearest = edges_[w].way_to(p);
        l[w] = length(nearest);
        if (w == 0) up = (1 / std::max(l[0], 1.0)) * nearest;
      }
      p = p + 0.5 * (l[1] - l[0]) * up;
      off = closes * (0.5 * (l[0] + l[1]) - d);
    }
    if (off < -2 * simplified_) return;
    if (off > 1) uncertain_.add(p, d);
  }
}

std::vector<char> CuspCorrector::kept() const {
  std::vector<char> kept(points_.size(), 0);
  for (const UncertainTopology::Place& place : uncertain_.kept()) {
    const double reach = uncertain_.reach(place);
    tree_.any_nearer(place.at.x, place.at.y, reach, [&](std::size_t i) {
      if (square_distance(place.at, to_vec(points_[i]), to_vec(points_[next_[i]])) <= reach * reach)
        kept[i] = kept[next_[i]] = 1;
      return false;
    });
  }
  return kept;
}

bool CuspCorrector::within(geometry::Vec place, double d) const {
  return !tree_.any_nearer(place.x, place.y, d, [&](std::size_t i) {
    return square_distance(place, to_vec(points_[i]), to_vec(points_[next_[i]])) < d * d;
  });
}

// Returns the maximum distance of a corrected cusp.
double CuspCorrector::furthest(const Side& before, const Side& after) const {
  // The directions of the sides differ by pi - 2 a.
  const double sine = std::sqrt(std::max(0.0, 0.5 * (1 + dot(before.along, after.along))));
  return std::min(kFurthest, 1.5 * simplified_ / std::max(sine, 1e-3) + simplified_);
}

bool CuspCorrector::find(geometry::Vec& cusp, const Side& before, const Side& after, double d) {
  const double furthest = this->furthest(before, after);
  const double reach = furthest + 2 * simplified_ + kAround * d;
  look(before, after, reach, edges_[0]);
  look(after, before, reach, edges_[1]);
  if (edges_[0].empty() || edges_[1].empty()) return false;
  geometry::Vec p = cusp;
  for (int step = 0; step < kSteps; ++step) {
    double missing[2];
    geometry::Vec up[2];
    for (int w = 0; w < 2; ++w) {
      up[w] = edges_[w].way_to(p);
      const double l = length(up[w]);
      if (l == 0) return false;
      up[w] = (1 / l) * up[w];
      missing[w] = d - l;
    }
    if (std::abs(missing[0]) < kFound && std::abs(missing[1]) < kFound) {
      cusp = p;
      return true;
    }
    const double det = cross(up[0], up[1]);
    if (std::abs(det) < 1e-4) return false;
    p = p + geometry::Vec{(missing[0] * up[1].y - missing[1] * up[0].y) / det,
                          (missing[1] * up[0].x - missing[0] * up[1].x) / det};
    if (dot(p - cusp, p - cusp) > furthest * furthest) return false;
  }
  return false;
}

}  // namespace firn::slice
