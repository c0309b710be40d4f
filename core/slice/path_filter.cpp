#include "core/slice/path_filter.h"

#include <cmath>

namespace firn::slice {

void PathFilter::append(std::span<const Point> ring, Rings& to) {
  const bool spaced = spacing_ > 0.0;
  if (spaced) space(ring);
  const std::span<const Point> left = spaced ? std::span<const Point>(points_) : ring;
  if (left.size() < 3) return;
  if (!(tolerance_ > 0.0)) return to.add(left);
  const std::size_t n = left.size();
  x_.resize(n + 1);
  y_.resize(n + 1);
  for (std::size_t i = 0; i <= n; ++i) {
    x_[i] = left[i < n ? i : 0].x;
    y_[i] = left[i < n ? i : 0].y;
  }
  keep_.assign(n + 1, 0);
  simplify();
  const std::size_t before = to.points.size();
  for (std::size_t i = 0; i < n; ++i)
    if (keep_[i]) to.points.push_back(left[i]);
  if (to.points.size() - before < 3)
    to.points.resize(before);
  else
    to.ends.push_back(std::uint32_t(to.points.size()));
}

void PathFilter::space(std::span<const Point> ring) {
  points_.clear();
  const double least = spacing_ * spacing_;
  const auto near = [&](const Point& p, const Point& q) {
    const double dx = double(p.x) - q.x, dy = double(p.y) - q.y;
    return dx * dx + dy * dy < least;
  };
  for (const Point& p : ring)
    if (points_.empty() || !near(p, points_.back())) points_.push_back(p);
  while (points_.size() > 1 && near(points_.back(), points_.front())) points_.pop_back();
}

void PathFilter::simplify() {
  const std::uint32_t n = std::uint32_t(x_.size()) - 1;  // point n is point 0 again
  std::uint32_t far = 0;
  double farthest = -1.0;
  for (std::uint32_t i = 1; i < n; ++i) {
    const double dx = x_[i] - x_[0], dy = y_[i] - y_[0], d = dx * dx + dy * dy;
    if (d > farthest) {
      farthest = d;
      far = i;
    }
  }
  keep_[0] = keep_[far] = 1;
  stack_.assign({{0, far}, {far, n}});
  const double limit = tolerance_ * tolerance_;
  while (!stack_.empty()) {
    const auto [a, b] = stack_.back();
    stack_.pop_back();
    const double ex = x_[b] - x_[a], ey = y_[b] - y_[a], length2 = ex * ex + ey * ey;
    // Square distances from the chord, times its square length: no division in the loop.
    double worst = limit * length2;
    std::uint32_t split = 0;
    for (std::uint32_t i = a + 1; i < b; ++i) {
      const double dx = x_[i] - x_[a], dy = y_[i] - y_[a];
      const double cross = dx * ey - dy * ex, forward = dx * ex + dy * ey;
      double d = cross * cross;
      if (forward < 0.0)
        d = (dx * dx + dy * dy) * length2;
      else if (forward > length2)
        d = ((dx - ex) * (dx - ex) + (dy - ey) * (dy - ey)) * length2;
      if (d > worst) {
        worst = d;
        split = i;
      }
    }
    if (split == 0) continue;
    keep_[split] = 1;
    stack_.push_back({split, b});
    stack_.push_back({a, split});
  }
}

}  // namespace firn::slice
