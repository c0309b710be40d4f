#include "core/slice/next_level.h"

#include <algorithm>
#include <utility>

namespace firn::slice {
namespace {

constexpr std::size_t kGuesses = 5;
constexpr double kLonely = 3.0 * kUnitsPerMm;

}  // namespace

void NextLevel::take(const Rings& rings, double reach) {
  reach_ = reach;
  last_ = 0, lonely_square_ = 0, built_ = false;
  edges_.resize(rings.points.size());
  std::size_t begin = 0;
  for (const std::uint32_t end : rings.ends) {
    Vec b = to_vec(rings.points[begin]);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t next = i + 1 < end ? i + 1 : begin;
      const Vec a = std::exchange(b, to_vec(rings.points[next])), way = b - a;
      const double square = dot(way, way);
      edges_[i] = {a, way, square > 0 ? 1 / square : 0.0, std::uint32_t(next)};
    }
    begin = end;
  }
}

template <class F>
void NextLevel::touching(Vec p, double reach, F&& f) {
  if (!built_) {
    tree_.resize(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const Point from = to_point(edges_[i].at), to = to_point(edges_[i].at + edges_[i].way);
      tree_.set(i, std::min(from.x, to.x), std::min(from.y, to.y), std::max(from.x, to.x), std::max(from.y, to.y));
    }
    tree_.build();
    built_ = true;
  }
  tree_.touching(box_about(p.x, p.y, reach), f);
}

bool NextLevel::within(Vec p, double limit) {
  const double square = limit * limit;
  const std::size_t n = edges_.size();
  if (n == 0 || dot(p - lonely_, p - lonely_) < lonely_square_) return false;
  for (std::size_t back = last_, ahead = last_, tried = 0; tried < kGuesses; ++tried) {
    const std::size_t e = tried % 2 ? back : ahead;
    if (edges_[e].within(p, square)) {
      last_ = e;
      return true;
    }
    if (tried % 2 == 0) ahead = ahead + 1 < n ? ahead + 1 : 0;
    if (tried % 2 || tried == 0) back = back ? back - 1 : n - 1;
  }
  // Places nearer to this one than it is too far from the next level are too far as well.
  const double found = clearance(p, limit + kLonely - reach_) + reach_;
  if (found <= limit) return true;
  lonely_ = p, lonely_square_ = (found - limit) * (found - limit);
  return false;
}

bool NextLevel::way_within(Vec a, Vec b, double limit) {
  const double square = limit * limit;
  std::size_t e = last_;
  for (std::size_t steps = 0; steps < kGuesses; ++steps, e = edges_[e].next) {
    if (edges_[e].within(b, square)) {
      last_ = e;
      return true;
    }
    if (square_distance(edges_[edges_[e].next].at, a, b) > square) return false;
  }
  return false;
}

double NextLevel::clearance(Vec p, double limit) {
  if (edges_.empty()) return limit;
  const double furthest = limit + reach_;
  double best = std::min(furthest * furthest, edges_[last_].square_distance(p));
  touching(p, std::sqrt(best), [&](std::size_t e) {
    const double square = edges_[e].square_distance(p);
    if (square < best) best = square, last_ = e;
  });
  return std::sqrt(best) - reach_;
}

}  // namespace firn::slice
