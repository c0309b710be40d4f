#include "core/slice/offset/exact_tips.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace firn::slice {
namespace {

constexpr double kFurthest = 3.0 * kUnitsPerMm;  // tips that would move by more stay
constexpr double kFarOff = 16;     // thinnings: walls so nearly parallel may close, or part, nearby
constexpr double kNarrow = -0.95;  // cosine of the turn at a tip of nearly parallel walls
constexpr double kEvery = 2;       // thinnings
constexpr double kFound = 0.5;     // units
constexpr int kSteps = 24;
// Feet move by more than the tip where a wall bends about it: so much of the distance is looked at to either
// side.
constexpr double kAround = 0.1;

}  // namespace

void ExactTips::take(const Rings& contours) {
  points_ = contours.points;
  doubts_.forget();
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

// Edges about a wall's foot that run its way rather than the other's.
void ExactTips::look(const Wall& wall, const Wall& other, double reach, WallEdges& edges) const {
  edges.clear();
  tree_.eights_touching(box_about(wall.foot.x, wall.foot.y, reach), [&](std::size_t first, unsigned met) {
    edges.add(points_, next_.data(), first, met, wall.along, other.along);
  });
}

bool ExactTips::move(Vec& tip, const Wall& before, const Wall& after, double d) {
  if (doubts_.exact(tip, d)) return false;
  const Vec was = tip;
  const bool found = find(tip, before, after, d);
  if (!asks_) return found;
  if (dot(before.along, after.along) < kNarrow) {
    const Vec outward = 0.5 * (before.along - after.along);
    const double far = furthest(before, after) - length(tip - was);
    look_along(tip, outward, far, 1, d);
    look_along(tip, -1 * outward, far, -1, d);
  }
  if (!found && dot(before.along, after.along) < 0) doubts_.add(tip, d);
  if (const double way = length(tip - was); way > kFarOff * thinned_) {
    const int steps = 1 + int(way / doubts_.spacing());
    for (int k = 0; k <= steps; ++k) doubts_.add(was + (double(k) / steps) * (tip - was), d);
  }
  return found;
}

// Beyond a tip walls so nearly parallel may open again, if only by what the thinning took, and before it they
// may close.
// @param closes +1: beyond it, -1: before it
void ExactTips::look_along(Vec tip, Vec direction, double far, double closes, double d) {
  if (edges_[0].empty() || edges_[1].empty()) return;
  const double step = kEvery * thinned_;
  for (double way = step; way < far; way += step) {
    Vec p = tip + way * direction, up;
    double off = 0;
    for (int centring = 0; centring < 2; ++centring) {
      double l[2];
      for (int w = 0; w < 2; ++w) {
        const Vec nearest = edges_[w].way_to(p);
        l[w] = length(nearest);
        if (w == 0) up = (1 / std::max(l[0], 1.0)) * nearest;
      }
      p = p + 0.5 * (l[1] - l[0]) * up;
      off = closes * (0.5 * (l[0] + l[1]) - d);
    }
    if (off < -2 * thinned_) return;
    if (off > 1) doubts_.add(p, d);
  }
}

std::vector<char> ExactTips::kept() const {
  std::vector<char> kept(points_.size(), 0);
  for (const Doubts::Doubt& doubt : doubts_.kept()) {
    const double reach = doubts_.reach(doubt);
    tree_.any_nearer(doubt.at.x, doubt.at.y, reach, [&](std::size_t i) {
      if (square_distance(doubt.at, to_vec(points_[i]), to_vec(points_[next_[i]])) <= reach * reach)
        kept[i] = kept[next_[i]] = 1;
      return false;
    });
  }
  return kept;
}

bool ExactTips::within(Vec place, double d) const {
  return !tree_.any_nearer(place.x, place.y, d, [&](std::size_t i) {
    return square_distance(place, to_vec(points_[i]), to_vec(points_[next_[i]])) < d * d;
  });
}

// Of the places of a tip.
double ExactTips::furthest(const Wall& before, const Wall& after) const {
  // Walls' directions are a turn of pi - 2 a apart.
  const double sine = std::sqrt(std::max(0.0, 0.5 * (1 + dot(before.along, after.along))));
  return std::min(kFurthest, 1.5 * thinned_ / std::max(sine, 1e-3) + thinned_);
}

bool ExactTips::find(Vec& tip, const Wall& before, const Wall& after, double d) {
  const double furthest = this->furthest(before, after);
  const double reach = furthest + 2 * thinned_ + kAround * d;
  look(before, after, reach, edges_[0]);
  look(after, before, reach, edges_[1]);
  if (edges_[0].empty() || edges_[1].empty()) return false;
  Vec p = tip;
  for (int step = 0; step < kSteps; ++step) {
    double lacks[2];
    Vec up[2];
    for (int w = 0; w < 2; ++w) {
      up[w] = edges_[w].way_to(p);
      const double l = length(up[w]);
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
    p = p +
        Vec{(lacks[0] * up[1].y - lacks[1] * up[0].y) / det, (lacks[1] * up[0].x - lacks[0] * up[1].x) / det};
    if (dot(p - tip, p - tip) > furthest * furthest) return false;
  }
  return false;
}

}  // namespace firn::slice
