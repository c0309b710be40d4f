#include "core/geometry/edge_grid.h"

#include <cmath>

namespace firn::slice {

template <class Visit>
void EdgeGrid::pass(const Edge& e, std::int32_t margin, const Visit& visit) const {
  const auto column = [&](std::int64_t x) {
    return std::size_t(std::clamp<std::int64_t>((x - low_x_) >> shift_, 0, std::int64_t(across_) - 1));
  };
  const auto row = [&](std::int64_t y) {
    return std::size_t(std::clamp<std::int64_t>((y - low_y_) >> shift_, 0, std::int64_t(along_) - 1));
  };
  const std::int64_t left = std::min(e.a.x, e.b.x) - std::int64_t(margin),
                     right = std::max(e.a.x, e.b.x) + std::int64_t(margin);
  const std::int64_t low = std::min(e.a.y, e.b.y) - std::int64_t(margin),
                     high = std::max(e.a.y, e.b.y) + std::int64_t(margin);
  const std::size_t c0 = column(left), c1 = column(right), r0 = row(low), r1 = row(high);
  if (c0 == c1 || r0 == r1 || e.a.y == e.b.y) {
    for (std::size_t r = r0; r <= r1; ++r)
      for (std::size_t c = c0; c <= c1; ++c) visit(r * across_ + c);
    return;
  }
  // Row by row: the part of the edge within the row and the margin, with room for rounding.
  const double slope = (double(e.b.x) - e.a.x) / (double(e.b.y) - e.a.y), room = margin + 2.0;
  for (std::size_t r = r0; r <= r1; ++r) {
    const double bottom = double(low_y_ + (std::int64_t(r) << shift_)) - room;
    const double top = double(low_y_ + (std::int64_t(r + 1) << shift_)) + room;
    const double y0 = std::max(bottom, double(low)), y1 = std::min(top, double(high));
    const double x0 = e.a.x + (y0 - e.a.y) * slope, x1 = e.a.x + (y1 - e.a.y) * slope;
    const std::int64_t from = std::max(left, std::int64_t(std::floor(std::min(x0, x1) - room)));
    const std::int64_t to = std::min(right, std::int64_t(std::ceil(std::max(x0, x1) + room)));
    for (std::size_t c = column(from); c <= column(to); ++c) visit(r * across_ + c);
  }
}

void EdgeGrid::build(std::span<const Edge> edges, std::int32_t margin) {
  first_.clear();
  edges_.clear();
  if (edges.empty()) return;
  std::int64_t high_x = edges[0].a.x, high_y = edges[0].a.y;
  low_x_ = high_x;
  low_y_ = high_y;
  for (const Edge& e : edges)
    for (const Point& p : {e.a, e.b}) {
      low_x_ = std::min<std::int64_t>(low_x_, p.x);
      low_y_ = std::min<std::int64_t>(low_y_, p.y);
      high_x = std::max<std::int64_t>(high_x, p.x);
      high_y = std::max<std::int64_t>(high_y, p.y);
    }
  const std::uint64_t width = std::uint64_t(high_x - low_x_), height = std::uint64_t(high_y - low_y_);
  const std::uint64_t most = std::max<std::uint64_t>(16, 4 * edges.size());
  for (shift_ = 0; ((width >> shift_) + 1) * ((height >> shift_) + 1) > most;) ++shift_;
  across_ = std::size_t(width >> shift_) + 1;
  along_ = std::size_t(height >> shift_) + 1;
  // Counted, then placed from the back: first_[n] ends as the start of cell n.
  first_.assign(across_ * along_ + 1, 0);
  for (const Edge& e : edges) pass(e, margin, [&](std::size_t cell) { ++first_[cell]; });
  for (std::size_t n = 1; n < first_.size(); ++n) first_[n] += first_[n - 1];
  edges_.resize(first_.back());
  for (std::size_t i = edges.size(); i-- > 0;)
    pass(edges[i], margin, [&](std::size_t cell) { edges_[--first_[cell]] = std::uint32_t(i); });
}

}  // namespace firn::slice
