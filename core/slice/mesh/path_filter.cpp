#include "core/slice/mesh/path_filter.h"

namespace firn::slice {

void PathFilter::append(std::span<const geometry::Point> ring, geometry::Rings& to) {
  const bool spaced = spacing_ > 0.0;
  if (spaced) space(ring);
  const std::span<const geometry::Point> left = spaced ? std::span<const geometry::Point>(points_) : ring;
  if (left.size() < 3) return;
  if (!(tolerance_ > 0.0)) return to.add(left);
  if (line_.size() < left.size())
    line_.resize(left.size());  // never shrinks, because regrown elements would be initialized again
  for (std::size_t i = 0; i < left.size(); ++i) line_[i] = to_vec(left[i]);
  draw_(std::span(line_).first(left.size()), tolerance_, to);
}

void PathFilter::space(std::span<const geometry::Point> ring) {
  points_.clear();
  const double least = spacing_ * spacing_;
  const auto near = [&](const geometry::Point& p, const geometry::Point& q) {
    const double dx = double(p.x) - q.x, dy = double(p.y) - q.y;
    return dx * dx + dy * dy < least;
  };
  for (const geometry::Point& p : ring)
    if (points_.empty() || !near(p, points_.back())) points_.push_back(p);
  while (points_.size() > 1 && near(points_.back(), points_.front())) points_.pop_back();
}

}  // namespace firn::slice
