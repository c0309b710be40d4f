#include "core/slice/medial/next_level.h"

#include <algorithm>
#include <numeric>

namespace firn::slice {
namespace {

constexpr std::size_t kGuesses = 5;
constexpr double kLonely = 3.0 * geometry::kUnitsPerMm;

}  // namespace

void NextLevel::take(const geometry::Rings& rings, double reach) {
  reach_ = reach;
  last_ = 0;
  lonely_square_ = 0;
  built_ = false;
  rings_ = &rings;
  points_ = rings.points;
  following_.resize(points_.size());
  std::iota(following_.begin(), following_.end(), 1u);
  std::uint32_t begin = 0;
  for (const std::uint32_t end : rings.ends) {
    if (end > begin) following_[end - 1] = begin;
    begin = end;
  }
}

template <class F>
void NextLevel::touching(geometry::Vec p, double reach, F&& f) {
  if (!built_) {
    tree_.set_rings(*rings_);
    tree_.build();
    built_ = true;
  }
  tree_.touching(geometry::box_about(p.x, p.y, reach), f);
}

bool NextLevel::within(geometry::Vec p, double limit) {
  const double square = limit * limit;
  const std::size_t n = points_.size();
  if (n == 0 || dot(p - lonely_, p - lonely_) < lonely_square_) return false;
  for (std::size_t back = last_, ahead = last_, tried = 0; tried < kGuesses; ++tried) {
    const std::size_t e = tried % 2 ? back : ahead;
    if (square_distance(e, p) <= square) {
      last_ = e;
      return true;
    }
    if (tried % 2 == 0) ahead = ahead + 1 < n ? ahead + 1 : 0;
    if (tried % 2 || tried == 0) back = back ? back - 1 : n - 1;
  }
  // Points nearer to this one than its excess over the limit are beyond the limit as well.
  const double found = clearance(p, limit + kLonely - reach_) + reach_;
  if (found <= limit) return true;
  lonely_ = p;
  lonely_square_ = (found - limit) * (found - limit);
  return false;
}

bool NextLevel::way_within(geometry::Vec a, geometry::Vec b, double limit) {
  const double square = limit * limit;
  std::size_t e = last_;
  for (std::size_t steps = 0; steps < kGuesses; ++steps, e = following_[e]) {
    if (square_distance(e, b) <= square) {
      last_ = e;
      return true;
    }
    if (geometry::square_distance(to_vec(points_[following_[e]]), a, b) > square) return false;
  }
  return false;
}

bool NextLevel::snap(geometry::Vec& p, double limit) {
  if (points_.empty()) return false;
  double best = limit * limit;
  bool found = false;
  touching(p, limit, [&](std::size_t e) {
    const double square = square_distance(e, p);
    if (square >= best) return;
    best = square;
    last_ = e;
    found = true;
  });
  if (found) p = nearest(last_, p);
  return found;
}

double NextLevel::clearance(geometry::Vec p, double limit) {
  if (points_.empty()) return limit;
  const double furthest = limit + reach_;
  double best = std::min(furthest * furthest, square_distance(last_, p));
  touching(p, std::sqrt(best), [&](std::size_t e) {
    const double square = square_distance(e, p);
    if (square >= best) return;
    best = square;
    last_ = e;
  });
  return std::sqrt(best) - reach_;
}

}  // namespace firn::slice
