#include "core/slice/medial/feet.h"

#include <algorithm>
#include <cmath>

namespace firn::slice {
namespace {

constexpr double kStep = 0.6 * kUnitsPerMm;   // at most so far apart
constexpr double kClose = 0.3 * kUnitsPerMm;  // no closer together
constexpr double kTip = 0.15 * kUnitsPerMm;   // from a tip to the foot beside it
constexpr double kTipFacing = -0.174;         // cosine between the normals of a tip's walls

bool near(Vec a, Vec b) { return dot(a - b, a - b) < kClose * kClose; }

}  // namespace

void Feet::begin(double limit, double spot_at, double enough, bool cores) {
  limit_ = limit, spot_at_ = spot_at, enough_ = enough, cores_ = cores;
  clear();
}

void Feet::clear() {
  run_ = 0, way_ = 0;
  walls.clear();
  feet.clear();
}

void Feet::add_walls(std::span<const Vec> points, const Stretches::Stretch& stretch) {
  const std::size_t n = points.size();
  const std::size_t edges = stretch.closed ? n : n - 1;
  for (std::size_t i = 0; i < edges; ++i) {
    const Vec from = points[i], to = points[i + 1 < n ? i + 1 : 0], way = to - from;
    const bool sampled = stretch.closed || (i >= stretch.first && i < stretch.last);
    const double l = length(way);
    walls.push_back({from, to, (1 / l) * left_of(way), way_, l, sampled});
    way_ += l;
  }
}

void Feet::add(std::span<const Vec> points, const Stretches::Stretch& stretch) {
  const std::size_t n = points.size();
  first_wall_ = walls.size();
  stretch_ = &stretch;
  begun_ = false;
  add_walls(points, stretch);
  if (stretch.closed) {
    for (std::size_t i = 0; i < n; ++i) {
      stand_at_corner(i, i ? i - 1 : n - 1);
      stand_along(i);
    }
  } else {
    for (std::size_t i = stretch.first; i < stretch.last; ++i) {
      if (i > stretch.first) stand_at_corner(i, i - 1);
      stand_along(i);
    }
  }
  ++run_;
}

// Is the next level so near that the place is no spot's centre?
bool Feet::served(Vec spot) {
  if (enough_ <= 0) return false;
  if (!stretch_->cornered) return !next_.empty() && next_.within(spot, enough_);
  const Vec off = spot - stretch_->ahead;
  return dot(off, off) <= enough_ * enough_;
}

void Feet::stand(Vec at, Vec normal, double order) {
  const Vec tip = at + limit_ * normal;
  if (begun_ && near(at, last_at_) && near(tip, last_tip_)) return;
  if (served(at + spot_at_ * normal)) return;
  feet.push_back({at, normal, order, run_});
  begun_ = true, last_at_ = at, last_tip_ = tip;
}

// One foot in the middle of an edge, and as many as its length wants to both sides.
void Feet::stand_along(std::size_t edge) {
  const std::size_t wall = first_wall_ + edge;
  const Wall& w = walls[wall];
  if (w.length <= kClose) return;
  const Vec way = w.to - w.from;
  const int looks = 2 * int(0.5 * w.length / kStep) + 1;
  for (int k = 0; k < looks; ++k) {
    const double share = (k + 0.5) / looks;
    stand(w.from + share * way, w.normal, w.begin + share * w.length);
  }
}

// A corner looks between its walls' normals, if it is smooth; a reflex one in all directions between them.
void Feet::stand_at_corner(std::size_t edge, std::size_t before) {
  const std::size_t wall = first_wall_ + edge;
  const Vec at = walls[wall].from, from = walls[first_wall_ + before].normal, to = walls[wall].normal;
  const bool reflex = cross(from, to) < 0, back = dot(from, to) < -0.9;
  if (!reflex && dot(from, to) < 0.5) {
    if (!cores_ || dot(from, to) > kTipFacing) return;
    const Wall& w = walls[wall];
    const double share = std::min(0.25, kTip / w.length);
    stand(at + share * (w.to - at), to, w.begin + share * w.length);
    return;
  }
  const int steps = reflex ? std::max(2, int(std::ceil(length(to - from) * limit_ / kStep))) : 2;
  for (int k = 1; k < steps; ++k) {
    const double share = double(k) / steps;
    // By way of the middle direction, were the sum to vanish.
    const Vec turned = back ? 2 * std::min(share, 1 - share) * left_of(to - from) : Vec{};
    const Vec normal = (1 - share) * from + share * to + turned;
    const double l = length(normal);
    if (l > 0) stand(at, (1 / l) * normal, walls[wall].begin);
  }
}

}  // namespace firn::slice
